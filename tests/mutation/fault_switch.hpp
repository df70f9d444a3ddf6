#pragma once
// Faults of one token that a program turns on when it starts: tests/mutation/switches.py writes these calls into a copy
// of the sources, so that one build holds all faults of a run. SPINDLE_TWIN_FAULT=17 turns fault 17 on. Of a file that
// SPINDLE_TWIN_REACHED names, byte 17 becomes 1 where fault 17 is passed. Each object lists in its section `.fault` the
// faults that it asks for when it runs: what the compiler works out itself is not among them.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <initializer_list>
#include <type_traits>
#include <utility>

namespace spindle_twin_fault {

inline constexpr int capacity = 1 << 16;
inline unsigned char nowhere[capacity];
inline unsigned char* reached = nowhere;
inline int active = -1;

/// Before any other static object is made.
[[gnu::constructor(101)]] static void begin() {
  if (const char* number = std::getenv("SPINDLE_TWIN_FAULT")) active = std::atoi(number);
  const char* path = reached == nowhere ? std::getenv("SPINDLE_TWIN_REACHED") : nullptr;
  if (path == nullptr) return;
  const int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0 || ftruncate(file, capacity) != 0) std::abort();
  void* mapped =
      mmap(nullptr, capacity, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);  // outlives a program that is killed
  close(file);
  if (mapped == MAP_FAILED) std::abort();
  reached = static_cast<unsigned char*>(mapped);
}

/// True while fault N is on. Where the compiler has to work out the value: an error, or false, which `or_never` allows.
template <int N, bool or_never>
constexpr bool is() {
  if constexpr (or_never) {
    if (std::is_constant_evaluated()) return false;
  }
  asm volatile(".pushsection .fault,\"\",@progbits\n\t.long %c0\n\t.popsection" ::"i"(N));
  reached[N] = 1;
  return active == N;
}

/// One of two numbers or truth values.
template <int N, bool or_never, class T>
constexpr T one_of(T right, T wrong) {
  return is<N, or_never>() ? wrong : right;
}

template <int N, bool or_never, bool largest, class T>
constexpr const T& extreme(const T& a, const T& b) {
  return is<N, or_never>() == largest ? (b < a ? b : a) : (a < b ? b : a);
}
template <int N, bool or_never, bool largest, class T>
constexpr T extreme(std::initializer_list<T> values) {
  const T* found = values.begin();
  for (const T& value : values) {
    if (is<N, or_never>() == largest ? value < *found : *found < value) found = &value;
  }
  return *found;
}

/// Stands between two operators, as in `a < Between<17, false>{} < b`, so that what binds tighter or looser still does.
template <int N, bool or_never>
struct Between {};
template <int N, bool or_never, class A>
struct Left {
  const A& a;
};
template <int N, bool or_never, class B>
struct Right {
  const B& b;
};

template <class T>
concept OfEigen = requires {
  typename std::remove_cvref_t<T>::PlainObject;
};
template <class T>
concept Number = std::is_arithmetic_v<std::remove_cvref_t<T>>;

#define SPINDLE_TWIN_FAULT_OPERATOR(right, wrong)                                                                  \
  template <class A, int N, bool or_never>                                                                         \
  constexpr Left<N, or_never, A> operator right(const A& a, Between<N, or_never>) {                                \
    return {a};                                                                                                    \
  }                                                                                                                \
  template <int N, bool or_never, class A, class B>                                                                \
  requires(!OfEigen<A>) && requires(const A& a, const B& b) {                                                      \
    std::remove_cvref_t<decltype(a right b)>(a right b);                                                           \
    std::remove_cvref_t<decltype(a right b)>(a wrong b);                                                           \
  }                                                                                                                \
  constexpr std::remove_cvref_t<decltype(std::declval<const A&>() right std::declval<const B&>())> operator right( \
      Left<N, or_never, A> left, const B& b) {                                                                     \
    using Given = std::remove_cvref_t<decltype(left.a right b)>;                                                   \
    if (is<N, or_never>()) return Given(left.a wrong b);                                                           \
    return Given(left.a right b);                                                                                  \
  }
SPINDLE_TWIN_FAULT_OPERATOR(<, <=)
SPINDLE_TWIN_FAULT_OPERATOR(<=, <)
SPINDLE_TWIN_FAULT_OPERATOR(>, >=)
SPINDLE_TWIN_FAULT_OPERATOR(>=, >)
SPINDLE_TWIN_FAULT_OPERATOR(==, !=)
SPINDLE_TWIN_FAULT_OPERATOR(!=, ==)
SPINDLE_TWIN_FAULT_OPERATOR(+, -)
SPINDLE_TWIN_FAULT_OPERATOR(-, +)
SPINDLE_TWIN_FAULT_OPERATOR(*, /)
SPINDLE_TWIN_FAULT_OPERATOR(/, *)
#undef SPINDLE_TWIN_FAULT_OPERATOR

// Of Eigen's expressions the fault is a factor, so that they stay expressions and take no memory.
#define SPINDLE_TWIN_FAULT_SUM(right)                                    \
  template <int N, bool or_never, OfEigen A, OfEigen B>                  \
  auto operator right(Left<N, or_never, A> left, const B& b) {           \
    using Scalar = typename B::Scalar;                                   \
    return left.a right(is<N, or_never>() ? Scalar(-1) : Scalar(1)) * b; \
  }
SPINDLE_TWIN_FAULT_SUM(+)
SPINDLE_TWIN_FAULT_SUM(-)
#undef SPINDLE_TWIN_FAULT_SUM
#define SPINDLE_TWIN_FAULT_PRODUCT(right)                      \
  template <int N, bool or_never, OfEigen A, Number B>         \
  auto operator right(Left<N, or_never, A> left, const B& b) { \
    return left.a right(is<N, or_never>() ? B(1) / b : b);     \
  }
SPINDLE_TWIN_FAULT_PRODUCT(*)
SPINDLE_TWIN_FAULT_PRODUCT(/)
#undef SPINDLE_TWIN_FAULT_PRODUCT

#define SPINDLE_TWIN_FAULT_ASSIGNMENT(right, wrong)                                  \
  template <int N, bool or_never, class B>                                           \
  constexpr Right<N, or_never, B> operator right(Between<N, or_never>, const B& b) { \
    return {b};                                                                      \
  }                                                                                  \
  template <class A, int N, bool or_never, class B>                                  \
  requires requires(A && a, const B& b) {                                            \
    a right b;                                                                       \
    a wrong b;                                                                       \
  }                                                                                  \
  constexpr decltype(auto) operator right(A&& a, Right<N, or_never, B> of) {         \
    if (is<N, or_never>()) {                                                         \
      a wrong of.b;                                                                  \
    } else {                                                                         \
      a right of.b;                                                                  \
    }                                                                                \
    return static_cast<A&&>(a);                                                      \
  }
SPINDLE_TWIN_FAULT_ASSIGNMENT(+=, -=)
SPINDLE_TWIN_FAULT_ASSIGNMENT(-=, +=)
#undef SPINDLE_TWIN_FAULT_ASSIGNMENT

}  // namespace spindle_twin_fault

#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>

namespace spindle_twin::firmware {

/// The newest value from one writing thread to one reading thread (triple buffer): neither ever waits for the other,
/// and a value is always whole. Chosen over a seqlock because there the reader spins while a writer that was
/// preempted holds a value open, and the cycle thread is a reader too.
template <class T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  void write(const T& value) {
    values_[writing_] = value;
    writing_ = shared_.exchange(writing_ | fresh, std::memory_order_acq_rel) & index;
  }

  /// Copies the newest value; false, and `value` untouched, if nothing came since the last read.
  bool read(T& value) {
    if ((shared_.load(std::memory_order_relaxed) & fresh) == 0) return false;
    reading_ = shared_.exchange(reading_, std::memory_order_acq_rel) & index;
    value = values_[reading_];
    return true;
  }

 private:
  static constexpr unsigned fresh = 4;
  static constexpr unsigned index = 3;
  std::array<T, 3> values_{};
  alignas(64) std::atomic<unsigned> shared_{1};
  alignas(64) unsigned writing_ = 0;
  alignas(64) unsigned reading_ = 2;
};

/// Every value from one writing thread to one reading thread, in order; a full ring refuses instead of waiting.
template <class T, std::size_t capacity>
class Ring {
  static_assert(std::is_trivially_copyable_v<T>);
  static_assert((capacity & (capacity - 1)) == 0, "a power of two lets the counters wrap");

 public:
  bool push(const T& value) {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == capacity) return false;
    values_[end % capacity] = value;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  /// What is in it at least (writing thread) or at most (reading thread).
  std::size_t size() const { return end_.load(std::memory_order_acquire) - begin_.load(std::memory_order_acquire); }

  bool pop(T& value) {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    value = values_[begin % capacity];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, capacity> values_{};
  alignas(64) std::atomic<std::size_t> end_{0};
  alignas(64) std::atomic<std::size_t> begin_{0};
};

}  // namespace spindle_twin::firmware

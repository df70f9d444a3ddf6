#include "fem_offline/reduce/column_store.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>

namespace spindle_twin::fem_offline {
namespace {

std::string folder() {
  const char* given = std::getenv("TMPDIR");
  return given && *given ? given : "/tmp";
}

[[noreturn]] void fail(const char* what) {
  const std::string why = std::generic_category().message(errno);
  throw std::runtime_error(folder() + ": the file of columns cannot be " + what + ": " + why +
                           "; TMPDIR names another folder");
}

/// Calls move(data, bytes, place in the file) until `count` values from the file's `first_value` on have been moved.
template <typename Value, typename Move>
void all_of(Value* values, Eigen::Index count, Eigen::Index first_value, const char* what, const Move& move) {
  using Byte = std::conditional_t<std::is_const_v<Value>, const char, char>;
  auto* next = reinterpret_cast<Byte*>(values);
  auto left = static_cast<std::size_t>(count) * sizeof(Value);
  auto at = static_cast<off_t>(first_value) * static_cast<off_t>(sizeof(Value));
  while (left > 0) {
    const ssize_t done = move(next, left, at);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) fail(what);
    next += done;
    at += done;
    left -= static_cast<std::size_t>(done);
  }
}

}  // namespace

template <typename Stored>
ColumnStore<Stored>::ColumnStore(Eigen::Index rows, Eigen::Index cols) : rows_(rows), cols_(cols) {
  std::string path = folder() + "/spindle-twin-XXXXXX";
  file_ = mkostemp(path.data(), O_CLOEXEC);
  if (file_ < 0) fail("made");
  unlink(path.c_str());
  if (ftruncate(file_, rows * cols * static_cast<off_t>(sizeof(Stored))) != 0) {
    close(file_);
    fail("made");
  }
}

template <typename Stored>
ColumnStore<Stored>::~ColumnStore() {
  close(file_);
}

template <typename Stored>
void ColumnStore<Stored>::write(Eigen::Index first, const Eigen::MatrixXd& columns) {
  StoredMatrix rounded(columns.rows(), columns.cols());
  rounded = columns.cast<Stored>();
  all_of(std::as_const(rounded).data(), rounded.size(), first * rows_, "written",
         [&](const char* data, std::size_t size, off_t at) { return pwrite(file_, data, size, at); });
}

template <typename Stored>
void ColumnStore<Stored>::read(Eigen::Index first, Eigen::Index count, StoredMatrix& columns) const {
  columns.resize(rows_, count);
  all_of(columns.data(), columns.size(), first * rows_, "read",
         [&](char* data, std::size_t size, off_t at) { return pread(file_, data, size, at); });
}

template <typename Stored>
Eigen::MatrixXd ColumnStore<Stored>::block(Eigen::Index first, Eigen::Index count) const {
  StoredMatrix columns;
  read(first, count, columns);
  if constexpr (std::is_same_v<Stored, double>) {
    return columns;
  } else {
    return columns.template cast<double>();
  }
}

template <typename Stored>
Eigen::MatrixXd ColumnStore<Stored>::chosen(const std::vector<int>& indices) const {
  Eigen::MatrixXd columns(rows_, static_cast<Eigen::Index>(indices.size()));
  StoredMatrix one;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    read(indices[static_cast<std::size_t>(i)], 1, one);
    columns.col(i) = one.template cast<double>();
  }
  return columns;
}

template class ColumnStore<float>;
template class ColumnStore<double>;

}  // namespace spindle_twin::fem_offline

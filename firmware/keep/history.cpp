#include "firmware/keep/history.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

namespace spindle_twin::firmware {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t number_digits = 6;
constexpr std::size_t most_files = 1000;
constexpr std::size_t rows_at_once = 64;

std::string numbered(const fs::path& path, unsigned long number) {
  fs::path name = path;
  name.replace_filename(fmt::format("{}.{:06}{}", path.stem().string(), number, path.extension().string()));
  return name.string();
}

/// Of `name` as numbered() makes it of `path`; 0 of any other.
unsigned long number_of(const fs::path& path, const std::string& name) {
  const std::string begin = path.stem().string() + ".";
  const std::string end = path.extension().string();
  if (name.size() != begin.size() + number_digits + end.size()) return 0;
  const std::string digits = name.substr(begin.size(), number_digits);
  const bool fits = name.starts_with(begin) && name.ends_with(end) &&
                    std::all_of(digits.begin(), digits.end(), [](unsigned char each) { return std::isdigit(each); });
  return fits ? std::stoul(digits) : 0;
}

/// Offset behind the last whole row: the last end of a line in front of the first byte 0, which stands where a power
/// cut came before the data. Below 0 where the file cannot be read.
off_t end_of_rows(int file, off_t size) {
  std::array<char, 65536> part{};
  off_t end = 0;
  for (off_t at = 0; at < size;) {
    const ssize_t got = pread(file, part.data(), part.size(), at);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return -1;
    const std::string_view all(part.data(), static_cast<std::size_t>(got));
    const std::string_view text = all.substr(0, all.find('\0'));
    if (const std::size_t last = text.rfind('\n'); last != std::string_view::npos) {
      end = at + static_cast<off_t>(last) + 1;
    }
    if (text.size() < all.size()) return end;
    at += got;
  }
  return end;
}

/// Gives the file of before the next number, on the disk and without what a power cut or a full disk left of a row. One
/// without rows may be begun anew. False where that is not possible.
bool put_aside(const std::string& path, std::size_t header_bytes) {
  const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0) return errno == ENOENT;
  struct stat status {};
  bool fine = fstat(file, &status) == 0;
  const off_t end = fine ? end_of_rows(file, status.st_size) : 0;
  fine = fine && end >= 0 && (end == status.st_size || ftruncate(file, end) == 0) && fsync(file) == 0;
  const int reason = errno;
  close(file);
  errno = reason;
  if (!fine || end <= static_cast<off_t>(header_bytes)) return fine;
  return std::rename(path.c_str(), next_earlier_history(path).c_str()) == 0;
}

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

std::vector<std::string> earlier_histories(const std::string& path) {
  const fs::path file(path);
  std::error_code unknown;
  std::vector<std::string> found;
  for (const auto& entry : fs::directory_iterator(file.has_parent_path() ? file.parent_path() : ".", unknown)) {
    if (number_of(file, entry.path().filename().string()) > 0) found.push_back(entry.path().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::string next_earlier_history(const std::string& path) {
  const std::vector<std::string> earlier = earlier_histories(path);
  const unsigned long last = earlier.empty() ? 0 : number_of(path, fs::path(earlier.back()).filename().string());
  return numbered(path, last + 1);
}

std::uint64_t remove_oldest_histories(const std::string& path, std::uint64_t most_bytes) {
  const std::vector<std::string> files = earlier_histories(path);
  std::error_code unknown;
  std::uint64_t bytes = 0;
  std::size_t kept = 0;
  for (auto each = files.rbegin(); each != files.rend(); ++each) {
    const std::uint64_t more = fs::file_size(*each, unknown);
    if (!unknown && bytes + more <= most_bytes && kept < most_files) {
      bytes += more;
      ++kept;
    } else {
      most_bytes = bytes;  // what is older goes too, and what SQLite keeps beside it
      for (const char* end : {"", "-wal", "-shm"}) fs::remove(*each + end, unknown);
    }
  }
  return bytes;
}

History::History(HistoryPlan plan, const rom::Network& network, Troubles& troubles)
    : HistoryWriter(plan.path, troubles), plan_(std::move(plan)), header_(history_header(network) + "\n") {
  begin_file();
}

History::~History() { close_file(); }

void History::close_file() {
  if (file_ >= 0) close(file_);
  file_ = -1;
}

void History::fail(const char* what) {
  const int reason = errno;
  close_file();
  complain(what, std::strerror(reason));
}

bool History::begin_file() {
  close_file();
  written_ = 0;
  if (!put_aside(plan_.path, header_.size())) {
    fail("cannot be put aside");
    return false;
  }
  remove_oldest_histories(plan_.path, plan_.most_bytes - plan_.segment_bytes);
  file_ = open(plan_.path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0644);
  if (file_ < 0 || !write_all(file_, header_)) {
    fail("cannot be written");
    return false;
  }
  written_ = header_.size();
  note_file();
  works();
  return true;
}

bool History::is_cut() const {
  struct stat status {};
  return fstat(file_, &status) == 0 && static_cast<std::uint64_t>(status.st_size) < written_;
}

void History::write_rows(const std::string& rows, std::uint64_t count) {
  if (count == 0) return;
  if (file_ >= 0 && is_gone()) {
    errno = ENOENT;
    fail("was removed or replaced");
    begin_file();
  } else if (file_ >= 0 && is_cut()) {
    close_file();
    complain("is begun anew", "somebody has emptied it");
    begin_file();
  }
  const bool is_open = file_ >= 0 || (may_try() && begin_file());
  if (is_open && write_all(file_, rows)) {
    written_ += rows.size();
    return;
  }
  lose(count);
  if (!is_open) return;
  // What is there of a row would merge with the next one. A disk that is full can still be cut.
  const int reason = errno;
  [[maybe_unused]] const int cut = ftruncate(file_, static_cast<off_t>(written_));
  errno = reason;
  fail("cannot be written");
}

void History::drain() {
  Snapshot snapshot;
  std::string rows;
  std::uint64_t count = 0;
  while (ring().pop(snapshot)) {
    const bool gap = sequence_ != 0 && snapshot.sequence != sequence_ + 1;
    if (file_ >= 0 && (gap || written_ + rows.size() >= plan_.segment_bytes || count == rows_at_once)) {
      write_rows(rows, std::exchange(count, 0));
      rows.clear();
      if (file_ >= 0 && (gap || written_ >= plan_.segment_bytes)) begin_file();
    }
    sequence_ = snapshot.sequence;
    rows += history_row(snapshot) + "\n";
    ++count;
  }
  write_rows(rows, count);
}

}  // namespace spindle_twin::firmware

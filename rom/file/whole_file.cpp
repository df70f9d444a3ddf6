#include "rom/file/whole_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <system_error>

#include "rom/read/input_error.hpp"

namespace spindle_twin::rom {
namespace {

[[noreturn]] void refuse(const std::string& path, const char* what, const std::string& field = "") {
  const std::string reason = std::strerror(errno);
  throw InputError({path, 0}, field, std::string(what) + ": " + reason);
}

/// A rename would replace a device or fail on a folder.
void require_no_other_kind(const std::string& path, const std::string& field) {
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown) && !std::filesystem::is_regular_file(path, unknown)) {
    throw InputError({path, 0}, field, "cannot be written: it exists and is not a regular file");
  }
}

/// For mkstemp and mkdtemp, on the same file system as `path`; of "folder/" beside the folder, not in it.
std::string neighbour(const std::string& path) {
  const std::size_t end = path.find_last_not_of('/');
  std::string name = path.substr(0, end == std::string::npos ? path.size() : end + 1);
  return name.append(unfinished_mark).append("XXXXXX");
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }

 private:
  int number_;
};

/// Removes the temporary name; after a rename there is none left.
struct Temporary {
  std::string path;
  ~Temporary() { ::unlink(path.c_str()); }
};

/// The mask is the process's, and can be read by setting it only: one thread at a time, or one would put back what
/// another had set.
mode_t ordinary_permissions() {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  const mode_t mask = ::umask(022);
  ::umask(mask);
  return 0644 & ~mask;
}

/// A temporary file in the same folder, written and synced, then given its name by `publish`.
template <class Publish>
void write_beside(const std::string& path, std::span<const std::uint8_t> bytes, mode_t permissions,
                  const Publish& publish) {
  std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) folder = ".";
  std::string name = neighbour(path);
  const Descriptor file(::mkostemp(name.data(), O_CLOEXEC));
  if (file.get() < 0) refuse(path, "cannot be written");
  const Temporary temporary{name};
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t count = ::write(file.get(), bytes.data() + written, bytes.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse(path, "cannot be written");
    written += static_cast<std::size_t>(count);
  }
  if (::fchmod(file.get(), permissions) != 0 || ::fsync(file.get()) != 0) refuse(path, "cannot be written");
  if (publish(name.c_str()) != 0) refuse(path, "cannot be written");
  const Descriptor directory(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.get() < 0 || ::fsync(directory.get()) != 0) refuse(path, "its folder cannot be synced");
}

}  // namespace

void write_whole_file(const std::string& path, std::span<const std::uint8_t> bytes) {
  require_no_other_kind(path, "");
  write_beside(path, bytes, ordinary_permissions(),
               [&](const char* temporary) { return std::rename(temporary, path.c_str()); });
}

void check_writable(const std::string& path, const std::string& field) {
  require_no_other_kind(path, field);
  // A trial instead of access(): that says yes to root for folders that take no file.
  std::string name = neighbour(path);
  const Descriptor file(::mkostemp(name.data(), O_CLOEXEC));
  if (file.get() < 0) refuse(path, "cannot be written", field);
  const Temporary temporary{name};
}

std::string make_folder_beside(const std::string& path, const std::string& field) {
  std::string name = neighbour(path);
  if (::mkdtemp(name.data()) == nullptr) refuse(path, "no folder can be made", field);
  return name;
}

void write_private_file(const std::string& path, const std::string& text) {
  // Unlike a rename, a link never replaces; the temporary name goes when write_beside is done.
  write_beside(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()), 0600,
               [&](const char* temporary) { return ::link(temporary, path.c_str()); });
}

void write_whole_file(const std::string& path, const std::string& text) {
  write_whole_file(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::vector<std::uint8_t> read_whole_file(const std::string& path, std::uint64_t largest_bytes) {
  // Opening a pipe would otherwise wait until somebody writes to it.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) refuse(path, "cannot be opened for reading");
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) refuse(path, "cannot be read");
  if (!S_ISREG(status.st_mode)) throw InputError({path, 0}, "", "is not a regular file");
  if (static_cast<std::uint64_t>(status.st_size) > largest_bytes) {
    throw InputError(
        {path, 0}, "",
        std::to_string(status.st_size) + " bytes; at most " + std::to_string(largest_bytes) + " are allowed");
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(status.st_size));
  std::size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t count = ::read(file.get(), bytes.data() + have, bytes.size() - have);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse(path, "cannot be read");
    if (count == 0) break;  // cut short while it was read; the header's length will say so
    have += static_cast<std::size_t>(count);
  }
  bytes.resize(have);
  return bytes;
}

}  // namespace spindle_twin::rom

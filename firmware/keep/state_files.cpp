#include "firmware/keep/state_files.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "firmware/keep/history.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {

bool exists_as_file(const std::string& path) {
  std::error_code unknown;
  const auto status = std::filesystem::status(path, unknown);
  if (!std::filesystem::exists(status)) return false;
  if (std::filesystem::is_regular_file(status)) return true;
  throw rom::InputError({path, 0}, "", "it exists and is not a regular file");
}

std::string put_state_aside(const std::string& path) {
  const std::string aside = next_earlier_history(path);
  if (std::rename(path.c_str(), aside.c_str()) == 0) return "; it is kept as " + aside;
  if (errno == ENOENT) return "";
  return std::string("; it could not be put aside (") + std::strerror(errno) + ") and will be written over";
}

int remove_left_overs(const std::string& path) {
  constexpr std::size_t letters = 6;
  const std::filesystem::path file(path);
  const std::string begin = file.filename().string().append(rom::unfinished_mark);
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code unknown;
  std::vector<std::filesystem::path> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder, unknown)) {
    const std::string name = entry.path().filename().string();
    const bool is_temporary = name.size() == begin.size() + letters && name.starts_with(begin) &&
                              std::all_of(name.end() - letters, name.end(),
                                          [](char letter) { return std::isalnum(static_cast<unsigned char>(letter)); });
    if (is_temporary && std::filesystem::is_regular_file(entry.symlink_status(unknown))) left.push_back(entry.path());
  }
  return static_cast<int>(std::count_if(left.begin(), left.end(), [&](const std::filesystem::path& temporary) {
    return std::filesystem::remove(temporary, unknown);
  }));
}

StateLock::StateLock(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    const std::string name = path + ".lock";
    int lock = open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
    // Left by another account, root for one; the file beside it can be replaced all the same, and flock needs no more.
    if (lock < 0 && errno == EACCES) lock = open(name.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (lock < 0) continue;
    locks_.push_back(lock);
    if (flock(lock, LOCK_EX | LOCK_NB) == 0) continue;
    release();
    throw rom::InputError({path, 0}, "", "another spindle-twind already writes this file");
  }
}

StateLock::~StateLock() { release(); }

void StateLock::release() {
  for (const int lock : locks_) close(lock);
  locks_.clear();
}

}  // namespace spindle_twin::firmware

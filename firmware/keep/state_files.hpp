#pragma once

#include <string>
#include <vector>

namespace spindle_twin::firmware {

/// Whether there is a file. Throws rom::InputError where `path` is something else that reading would wait for or could
/// not replace: a pipe, a socket, a device, a folder.
bool exists_as_file(const std::string& path);

/// Removes what a writer of `path` that was killed has left beside it: `path`, rom::unfinished_mark and six letters or
/// digits, ordinary files only. Returns how many. Only where nobody else writes `path` (StateLock).
int remove_left_overs(const std::string& path);

/// A file that cannot be used is not written over: it gets the next number, "twin.000001.checkpoint", for a person to
/// look at. Gives words for the end of a line of the log: where it lies now, or that it could not be put aside; none
/// where there is no file.
std::string put_state_aside(const std::string& path);

/// Keeps other daemons away from the files that this one writes, whatever their configurations are called: an
/// exclusive flock on `<file>.lock` for each, which the kernel drops however the process ends. The lock files stay;
/// they are empty and mean nothing by themselves. Turned down: a lock on the configuration, which an editor replaces
/// and a second configuration does not share; one on the file itself, which each writing replaces; one on the folder,
/// in which two spindles may keep their files.
class StateLock {
 public:
  /// Throws rom::InputError naming the file that another process writes. One whose lock file can neither be made nor
  /// read is not locked: its folder takes no file, and that is said where it is written.
  explicit StateLock(const std::vector<std::string>& paths);
  ~StateLock();
  StateLock(const StateLock&) = delete;
  StateLock& operator=(const StateLock&) = delete;

 private:
  void release();
  std::vector<int> locks_;
};

}  // namespace spindle_twin::firmware

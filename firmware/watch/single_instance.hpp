#pragma once

#include <string>

namespace spindle_twin::firmware {

/// Holds an exclusive lock (flock) on the configuration file as long as it lives; the kernel drops it however the
/// process ends. The configuration itself is locked, not a file beside it, so that nothing stale can be left over and
/// nothing needs to be written.
class SingleInstance {
 public:
  /// Throws rom::InputError if another process holds the lock or the file cannot be opened.
  explicit SingleInstance(const std::string& config_path);
  ~SingleInstance();
  SingleInstance(const SingleInstance&) = delete;
  SingleInstance& operator=(const SingleInstance&) = delete;

 private:
  int fd_;
};

}  // namespace spindle_twin::firmware

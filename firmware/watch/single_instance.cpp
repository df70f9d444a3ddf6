#include "firmware/watch/single_instance.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {

SingleInstance::SingleInstance(const std::string& config_path) : fd_(open(config_path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (fd_ >= 0 && flock(fd_, LOCK_EX | LOCK_NB) == 0) return;
  const int reason = errno;
  if (fd_ >= 0) close(fd_);
  throw rom::InputError({config_path, 0}, "",
                        reason == EWOULDBLOCK ? "another spindle-twind already runs with this configuration"
                                              : std::string("cannot be locked: ") + std::strerror(reason));
}

SingleInstance::~SingleInstance() { close(fd_); }

}  // namespace spindle_twin::firmware

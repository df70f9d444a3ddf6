#include "host_tools/commands/check_output.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {

void check_output(const std::string& path, const std::string& option) {
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown) && !std::filesystem::is_regular_file(path, unknown)) {
    throw rom::InputError({path, 0}, option, "cannot be written: it exists and is not a regular file");
  }
  // A trial instead of access(): that says yes to root for folders that take no file.
  std::string trial = path + ".XXXXXX";
  const int descriptor = ::mkstemp(trial.data());
  if (descriptor < 0) {
    const std::string reason = std::strerror(errno);
    throw rom::InputError({path, 0}, option, "cannot be written: " + reason);
  }
  ::close(descriptor);
  ::unlink(trial.c_str());
}

}  // namespace spindle_twin::host_tools

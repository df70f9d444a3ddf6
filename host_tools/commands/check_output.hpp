#pragma once

#include <string>

namespace spindle_twin::host_tools {

/// Throws rom::InputError, naming `option` and the system's reason, if `path` cannot become a file: before minutes of
/// work, not after them. Leaves nothing behind.
void check_output(const std::string& path, const std::string& option);

}  // namespace spindle_twin::host_tools

#pragma once

#include <string>

namespace spindle_twin::fem_offline {

/// Reads a description, builds its section and meshes it with few elements. Returns the message of the one error it
/// ended in, empty if it went through. Throws std::logic_error for an error that names no file or line; every other
/// exception passes.
std::string checked(const std::string& text);

}  // namespace spindle_twin::fem_offline

#pragma once

#include <string>

#include "fem_offline/model/build_model.hpp"
#include "host_tools/commands/plausibility.hpp"

namespace spindle_twin::host_tools {

/// The FE model of a description, whose heats, films and contacts are judged. Throws rom::InputError as
/// fem_offline::build_fe_model does, and for a network, of a .rom file or written by hand, saying what it is for.
fem_offline::FeModel read_model(const std::string& spindle_path, Plausibility& plausibility);

}  // namespace spindle_twin::host_tools

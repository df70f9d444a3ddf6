#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <string>

#include "fem_offline/reduce/choose_size.hpp"
#include "fem_offline/reduce/parameter_box.hpp"

namespace spindle_twin::host_tools {

/// Of --nodes.
inline constexpr int most_nodes = 400;

/// "0.05K,0.03um" or "0.05K,0.03um,0.3K": key points, deformations, part maxima; without the last one part maxima may
/// err six times as much as key points. Throws CLI::ValidationError for anything else.
fem_offline::Tolerance parse_tolerance(const std::string& text);

/// The box of that name, "whole" (contacts 0.1 to 10, films 0.2 to 5) or "small" (contacts 0.3 to 3, films 0.5 to 2),
/// with speeds up to 24000 rpm or a third more than the description's, whichever is faster.
fem_offline::ParameterBox named_box(const std::string& name, double reference_speed_rpm);

}  // namespace spindle_twin::host_tools

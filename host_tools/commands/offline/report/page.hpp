#pragma once

#include <string>

#include "host_tools/commands/offline/report/run_data.hpp"

namespace spindle_twin::host_tools {

/// One HTML page with the run's curves, section and table that opens without a network (host_tools/pages/run_page.js).
std::string run_page(const RunData& run);

/// The same table for a terminal.
std::string run_table(const RunData& run);

}  // namespace spindle_twin::host_tools

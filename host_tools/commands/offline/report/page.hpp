#pragma once

#include <string>

#include "host_tools/commands/offline/report/run_data.hpp"

namespace spindle_twin::host_tools {

/// One HTML page with the run's curves and its table that opens without a network: the charts are dygraphs (MIT), whose
/// files are read from `dygraphs_folder` and written into the page. Throws rom::InputError if they are not there.
std::string run_page(const RunData& run, const std::string& dygraphs_folder);

/// The same table for a terminal.
std::string run_table(const RunData& run);

}  // namespace spindle_twin::host_tools

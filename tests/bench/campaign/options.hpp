#pragma once

#include "tests/bench/campaign/models.hpp"
#include "tests/bench/command_line/command_line.hpp"

namespace spindle_twin::bench {

/// The options that every campaign has; `what_a_run_is` and `what_short_is` are the texts of --runs and --short.
void add_options(CommandLine& line, CampaignOptions& options, const char* what_a_run_is, const char* what_short_is);

}  // namespace spindle_twin::bench

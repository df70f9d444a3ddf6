#pragma once

namespace CLI {
class App;
}

namespace spindle_twin::host_tools {

/// After parsing, before the command runs: throws CLI::ValidationError (exit code 2) where a file that the command is
/// to write is one that it reads, by whatever path, or where two files to write are one. Inputs are the files among the
/// values of all other options.
void keep_inputs(CLI::App& command);

}  // namespace spindle_twin::host_tools

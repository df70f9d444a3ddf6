#pragma once

#include <functional>

namespace CLI {
class App;
}

/// What both programs of the host tool share: `spindle-twin`, which starts at once, and `spindle-twin-fem`, which loads
/// the FE libraries.
namespace spindle_twin::host_tools {

/// Adds the commands that need neither the FE model nor the offline part.
void add_edge_commands(CLI::App& app);

/// True if the first argument is a command of `app` or asks for its version: `app` can answer alone.
bool can_answer(const CLI::App& app, int argc, char** argv);

/// A program: `add_commands` says what it knows, then one command is parsed and run. Gives the exit code: 0, that of
/// the command, 2 for a wrong command line, 1 for what a command throws, which is said in one line on stderr.
int run_program(int argc, char** argv, const std::function<void(CLI::App&)>& add_commands);

}  // namespace spindle_twin::host_tools

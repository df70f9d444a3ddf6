#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

/// What both programs of the host tool share: `spindle-twin`, which starts at once, and `spindle-twin-fem`, which loads
/// the FE libraries, half a second of processor time.
namespace spindle_twin::host_tools {

/// Gives `app` its version, its help and the form of its messages: one line on stderr.
void prepare(CLI::App& app);

/// Adds the commands that need neither the FE model nor the offline part.
void add_edge_commands(CLI::App& app);

/// True if the first argument is a command of `app` or asks for its version: `app` can answer alone.
bool can_answer(const CLI::App& app, int argc, char** argv);

/// Parses and runs one command. Gives the exit code: 0, that of the command, or 2 for a wrong command line. Throws what
/// a command throws.
int run_command_line(CLI::App& app, int argc, char** argv);

}  // namespace spindle_twin::host_tools

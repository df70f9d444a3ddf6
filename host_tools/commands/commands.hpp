#pragma once

#include <string>

namespace CLI {
class App;
}

/// One function per command: it adds its subcommand with options to `app` and sets a callback that runs it.
/// A command prints results on stdout, progress and errors on stderr, and throws rom::InputError for bad input.
namespace spindle_twin::host_tools {

void add_inspect(CLI::App& app);
void add_diff(CLI::App& app);
void add_assemble(CLI::App& app);
void add_keys(CLI::App& app);
void add_sign(CLI::App& app);
void add_verify_signature(CLI::App& app);
void add_deploy(CLI::App& app);
void add_simulate(CLI::App& app);
void add_replay(CLI::App& app);
void add_history(CLI::App& app);
void add_evaluate(CLI::App& app);

/// Writes the FE model of a description for CalculiX and FreeFEM: its path, and a folder for either, empty for none.
using WriteDecks = void(const std::string& spindle_path, const std::string& calculix_directory,
                        const std::string& freefem_directory);
/// Without `write_decks`, which needs the offline part, the command takes networks only.
void add_export(CLI::App& app, WriteDecks* write_decks);

void add_identify(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_compare(CLI::App& app);
void add_thermal_test_report(CLI::App& app);
void add_laws(CLI::App& app);
void add_registers(CLI::App& app);

// In commands/offline, which the edge build does not have.
void add_solve(CLI::App& app);
void add_mesh(CLI::App& app);
void add_build(CLI::App& app);
void add_verify(CLI::App& app);
void add_verify_fem(CLI::App& app);
void add_plant(CLI::App& app);
void add_report(CLI::App& app);

}  // namespace spindle_twin::host_tools

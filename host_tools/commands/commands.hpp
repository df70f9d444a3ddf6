#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

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
void add_export(CLI::App& app);
void add_identify(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_compare(CLI::App& app);
void add_thermal_test_report(CLI::App& app);
void add_laws(CLI::App& app);
void add_registers(CLI::App& app);

#ifdef SPINDLE_TWIN_OFFLINE
void add_solve(CLI::App& app);
void add_mesh(CLI::App& app);
void add_build(CLI::App& app);
void add_verify(CLI::App& app);
void add_verify_fem(CLI::App& app);
void add_plant(CLI::App& app);
void add_report(CLI::App& app);
#endif

}  // namespace spindle_twin::host_tools

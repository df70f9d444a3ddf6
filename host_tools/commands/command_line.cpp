#include "host_tools/commands/command_line.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/kept_inputs.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr int usage_error = 2;

std::string usage_message(const CLI::App* app, const CLI::Error& error) {
  std::string command = "spindle-twin";
  for (const CLI::App* given : app->get_subcommands()) command += " " + given->get_name();
  return command + ": " + error.what() + "; see " + command + " --help\n";
}

bool has_command(const CLI::App& app, const std::string& name) {
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_name() == name) return true;
  }
  return false;
}

/// What to say where the first argument is no option and no command; else nothing.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  const std::string given = argc > 1 ? argv[1] : "-";
  if (given.starts_with("-") || has_command(app, given)) return "";
  std::string allowed;
  for (const CLI::App* command : app.get_subcommands({})) {
    allowed += (allowed.empty() ? "" : ", ") + command->get_name();
  }
  return "spindle-twin: no command " + given + ", allowed are " + allowed + "; see spindle-twin --help";
}

void prepare(CLI::App& app) {
  app.require_subcommand(1);
  app.set_version_flag("--version", SPINDLE_TWIN_VERSION, "print the version and exit");
  app.set_help_flag("-h,--help", "print this help and exit");
  app.failure_message(usage_message);
}

int run_command_line(CLI::App& app, int argc, char** argv) {
  if (const std::string unknown = unknown_command(app, argc, argv); !unknown.empty()) {
    std::fprintf(stderr, "%s\n", unknown.c_str());
    return usage_error;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : usage_error;
  }
  return 0;
}

/// The exit code of a command whose output has been taken, all of it; else 1: a full disk is no success.
int written_out(int exit_code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
  std::fprintf(stderr, "spindle-twin: standard output cannot be written: %s\n", std::strerror(errno));
  return exit_code == 0 ? 1 : exit_code;
}

}  // namespace

void add_edge_commands(CLI::App& app) {
  add_assemble(app);
  add_inspect(app);
  add_diff(app);
  add_keys(app);
  add_sign(app);
  add_verify_signature(app);
  add_deploy(app);
  add_simulate(app);
  add_replay(app);
  add_history(app);
  add_evaluate(app);
  add_identify(app);
  add_calibrate(app);
  add_thermal_test_report(app);
  add_compare(app);
  add_laws(app);
  add_registers(app);
}

bool can_answer(const CLI::App& app, int argc, char** argv) {
  const std::string given = argc > 1 ? argv[1] : "";
  return given == "--version" || has_command(app, given);
}

int run_program(int argc, char** argv, const std::function<void(CLI::App&)>& add_commands) {
  try {
    CLI::App app{"spindle-twin: thermal digital twin of a CNC spindle, host tool"};
    prepare(app);
    add_commands(app);
    for (CLI::App* command : app.get_subcommands({})) {
      command->parse_complete_callback([command] { keep_inputs(*command); });
    }
    return written_out(run_command_line(app, argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "spindle-twin: %s\n", error.what());
    return 1;
  }
}

}  // namespace spindle_twin::host_tools

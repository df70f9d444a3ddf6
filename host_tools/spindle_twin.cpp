#include <CLI/App.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "host_tools/commands/commands.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr int usage_error = 2;

std::string usage_message(const CLI::App* app, const CLI::Error& error) {
  std::string command = "spindle-twin";
  for (const CLI::App* given : app->get_subcommands()) command += " " + given->get_name();
  return command + ": " + error.what() + "; see " + command + " --help\n";
}

/// What to say where the first argument is no option and no command; else nothing.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  const std::string given = argc > 1 ? argv[1] : "-";
  if (given.starts_with("-")) return "";
  std::string allowed;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_name() == given) return "";
    allowed += (allowed.empty() ? "" : ", ") + command->get_name();
  }
  return "spindle-twin: no command " + given + ", allowed are " + allowed + "; see spindle-twin --help";
}

int run(int argc, char** argv) {
  CLI::App app{"spindle-twin: thermal digital twin of a CNC spindle, host tool"};
  app.require_subcommand(1);
  app.set_version_flag("--version", SPINDLE_TWIN_VERSION, "print the version and exit");
  app.set_help_flag("-h,--help", "print this help and exit");
  app.failure_message(usage_message);
#ifdef SPINDLE_TWIN_OFFLINE
  add_solve(app);
  add_mesh(app);
  add_build(app);
  add_verify(app);
  add_verify_fem(app);
#endif
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
  add_export(app);
  add_identify(app);
  add_calibrate(app);
  add_thermal_test_report(app);
  add_compare(app);
  add_laws(app);
  add_registers(app);
#ifdef SPINDLE_TWIN_OFFLINE
  add_plant(app);
  add_report(app);
#endif
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

}  // namespace
}  // namespace spindle_twin::host_tools

int main(int argc, char** argv) {
  try {
    return spindle_twin::host_tools::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "spindle-twin: %s\n", error.what());
    return 1;
  }
}

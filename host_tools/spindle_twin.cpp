#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <exception>

#include "host_tools/commands/commands.hpp"

int main(int argc, char** argv) {
  using namespace spindle_twin::host_tools;
  CLI::App app{"spindle-twin: thermal digital twin of a CNC spindle, host tool"};
  app.require_subcommand(1);
#ifdef SPINDLE_TWIN_OFFLINE
  add_solve(app);
  add_build(app);
  add_verify(app);
#endif
  add_inspect(app);
  add_simulate(app);
  add_registers(app);
#ifdef SPINDLE_TWIN_OFFLINE
  add_plant(app);
  add_report(app);
#endif
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "spindle-twin: %s\n", error.what());
    return 1;
  }
  return 0;
}

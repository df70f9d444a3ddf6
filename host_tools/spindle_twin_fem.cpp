#include <cstdio>
#include <exception>

#include "host_tools/commands/command_line.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/offline/export_decks.hpp"

namespace spindle_twin::host_tools {
namespace {

int run(int argc, char** argv) {
  CLI::App app{"spindle-twin: thermal digital twin of a CNC spindle, host tool"};
  prepare(app);
  add_solve(app);
  add_mesh(app);
  add_build(app);
  add_verify(app);
  add_verify_fem(app);
  add_export(app, export_decks);
  add_edge_commands(app);
  add_plant(app);
  add_report(app);
  return run_command_line(app, argc, argv);
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

#include "host_tools/commands/command_line.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/offline/export_decks.hpp"

int main(int argc, char** argv) {
  using namespace spindle_twin::host_tools;
  return run_program(argc, argv, [](CLI::App& app) {
    add_solve(app);
    add_mesh(app);
    add_build(app);
    add_verify(app);
    add_verify_fem(app);
    add_export(app, export_decks);
    add_edge_commands(app);
    add_plant(app);
    add_report(app);
  });
}

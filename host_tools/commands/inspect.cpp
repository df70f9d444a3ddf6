#include <memory>
#include <string>

#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/inspection.hpp"

// spindle-twin inspect reference.rom
namespace spindle_twin::host_tools {
namespace {

struct Options {
  std::string network;
  bool json = false;
};

}  // namespace

void add_inspect(CLI::App& app) {
  CLI::App* command = app.add_subcommand("inspect", "Show what a network file holds and check it");
  const auto options = std::make_shared<Options>();
  command->add_option("network", options->network, "network file, .rom")->required();
  command->add_flag("--json", options->json, "as JSON");
  command->callback([options] {
    const Inspection result = inspect(options->network);
    if (options->json) {
      print_json(result);
    } else {
      print_table(result);
    }
  });
}

}  // namespace spindle_twin::host_tools

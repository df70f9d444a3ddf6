#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "host_tools/commands/commands.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"

// spindle-twin assemble rom/by_hand/motor_spindle.toml -o motor_spindle.rom
namespace spindle_twin::host_tools {

void add_assemble(CLI::App& app) {
  struct AssembleOptions {
    std::string network;
    std::string output;
  };
  CLI::App* command = app.add_subcommand("assemble", "Make the network file of a network written by hand");
  const auto options = std::make_shared<AssembleOptions>();
  command->add_option("network", options->network, "nodes, conductances, heats and outputs, TOML")->required();
  command->add_option("-o,--output", options->output, "network file to write, .rom")->required();
  command->callback([options] {
    const rom::Network network = rom::read_by_hand(options->network);
    rom::check_writable(options->output, "--output");
    rom::write_network(network, options->output);
    std::printf("%s: %zu nodes, %zu contacts and films, %zu heats, hand-written: no certificate\n",
                options->output.c_str(), network.nodes.size(), network.boundaries.conductances.size(),
                network.boundaries.sources.size());
  });
}

}  // namespace spindle_twin::host_tools

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "host_tools/commands/check_output.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/commands/inspection.hpp"
#include "host_tools/network_page/page_data.hpp"
#include "rom/file/whole_file.hpp"

// spindle-twin inspect reference.rom
// spindle-twin inspect reference.rom --html page.html --speed 12000
namespace spindle_twin::host_tools {
namespace {

struct Options {
  std::string network;
  bool json = false;
  std::string page;
  std::optional<double> speed_rpm;
  std::optional<double> load;
};

void write_page(const Options& options, const rom::Network& network) {
  rom::OperatingState state = network.boundaries.operating;
  if (options.speed_rpm) state.speed_rpm = *options.speed_rpm;
  if (options.load) state.load = *options.load;
  rom::write_whole_file(options.page, network_page(network_page_data(network, state, options.network)));
  std::fprintf(stderr, "page in %s\n", options.page.c_str());
}

}  // namespace

void add_inspect(CLI::App& app) {
  CLI::App* command = app.add_subcommand("inspect", "Show what a network file holds and check it");
  const auto options = std::make_shared<Options>();
  command->add_option("network", options->network, "network file, .rom")->required();
  command->add_flag("--json", options->json, "as JSON");
  CLI::Option* page = command->add_option("--html", options->page,
                                          "write a page: section, heat flows and balances, sensitivities, certificate");
  command->add_option("--speed", options->speed_rpm, "of the page's steady state, rpm; else the operating state's")
      ->needs(page)
      ->check(finite_range(0.0, 1e6, "0 to 1e6 rpm"));
  command->add_option("--load", options->load, "of the same, fraction of the rated load")
      ->needs(page)
      ->check(finite_range(0.0, 10.0, "0 to 10"));
  command->callback([options] {
    if (!options->page.empty()) check_output(options->page, "--html");
    const Inspection result = inspect(options->network);
    if (!options->page.empty()) {
      write_page(*options, result.network);
      if (!options->json) return;
    }
    if (options->json) {
      print_json(result);
    } else {
      print_table(result);
    }
  });
}

}  // namespace spindle_twin::host_tools

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/inspection/inspection.hpp"
#include "host_tools/network_page/page_data.hpp"
#include "host_tools/network_page/steady_state.hpp"
#include "host_tools/pages/fill_page.hpp"
#include "host_tools/pages/page_texts.hpp"
#include "rom/file/whole_file.hpp"

// spindle-twin inspect reference.rom
// spindle-twin inspect reference.rom --html page.html --speed 12000
// spindle-twin inspect reference.rom --json --speed 12000
namespace spindle_twin::host_tools {
namespace {

struct InspectOptions {
  std::string network;
  bool json = false;
  std::string page;
  std::optional<double> speed_rpm;
  std::optional<double> load;
};

rom::OperatingState chosen_state(const InspectOptions& options, const rom::Network& network) {
  rom::OperatingState state = network.boundaries.operating;
  if (options.speed_rpm) state.speed_rpm = *options.speed_rpm;
  if (options.load) state.load = *options.load;
  return state;
}

void run_inspect(const InspectOptions& options) {
  if (options.page.empty() && !options.json && (options.speed_rpm || options.load)) {
    throw CLI::RequiresError(options.speed_rpm ? "--speed" : "--load", "--html or --json");
  }
  if (!options.page.empty()) rom::check_writable(options.page, "--html");
  const Inspection result = inspect(options.network);
  const rom::OperatingState state = chosen_state(options, result.network);
  if (!options.page.empty()) {
    rom::write_whole_file(options.page,
                          fill_page(network_page_text, network_page_data(result.network, state, options.network)));
    std::fprintf(stderr, "page in %s\n", options.page.c_str());
  }
  if (options.json) {
    const auto steady = steady_state(result.network, state);
    print_json(result, steady ? nlohmann::json(steady_state_json(*steady)) : nlohmann::json());
  } else if (options.page.empty()) {
    print_table(result);
  }
}

}  // namespace

void add_inspect(CLI::App& app) {
  CLI::App* command = app.add_subcommand("inspect", "Show what a network file holds and check it");
  const auto options = std::make_shared<InspectOptions>();
  command->add_option("network", options->network, "network file, .rom")->required();
  command->add_flag("--json", options->json, "as JSON");
  command->add_option("--html", options->page,
                      "write a page: section, heat flows and balances, warm-up, sensitivities, certificate");
  command->add_option("--speed", options->speed_rpm, "of the steady state shown, rpm; else the operating state's")
      ->check(finite_range(0.0, 1e6, "0 to 1e6 rpm"));
  command->add_option("--load", options->load, "of the same, fraction of the rated load")
      ->check(finite_range(0.0, 10.0, "0 to 10"));
  command->callback([options] { run_inspect(*options); });
}

}  // namespace spindle_twin::host_tools

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <limits>
#include <memory>

#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/offline/report/page.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

struct ReportOptions {
  std::string network;
  std::string history;
  std::string plant;
  std::string output;
  std::string part = "rotor";
  double until_s = std::numeric_limits<double>::infinity();
  bool table = false;
};

void run_report(const ReportOptions& options) {
  if (options.output.empty() && !options.table) {
    throw rom::InputError({}, "report", "nothing to do: give --output, --table or both");
  }
  const rom::Network network = rom::read_network(options.network);
  const rom::CsvTable history = rom::read_csv_table(options.history, rom::LastLine::may_be_cut);
  const rom::CsvTable plant = rom::read_csv_table(options.plant, rom::LastLine::may_be_cut);
  const RunData data = gather_run(network, history, plant, options.part, options.until_s);
  if (options.table) std::fputs(run_table(data).c_str(), stdout);
  if (options.output.empty()) return;
  rom::write_whole_file(options.output, run_page(data));
}

}  // namespace

void add_report(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("report", "Compare a twin's history with its simulated plant: table and HTML page");
  const auto options = std::make_shared<ReportOptions>();
  command->add_option("network", options->network, "the twin's network, .rom")->required();
  command->add_option("--history", options->history, "CSV that spindle-twind wrote")->required();
  command->add_option("--plant", options->plant, "CSV that spindle-twin plant --log wrote")->required();
  command->add_option("-o,--output", options->output, "HTML page to write");
  command->add_flag("--table", options->table, "print the table of the last row");
  command->add_option("--part", options->part, "part whose maximum is shown")->capture_default_str();
  command->add_option("--until-s", options->until_s, "last model time; without: as far as both files reach");
  command->callback([options] { run_report(*options); });
}

}  // namespace spindle_twin::host_tools

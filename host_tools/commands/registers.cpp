#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "firmware/serve/register_map.hpp"
#include "host_tools/commands/commands.hpp"

namespace spindle_twin::host_tools {
namespace {

struct RegistersOptions {
  bool markdown = false;
  bool csv = false;
  bool json = false;
};

void print_table() {
  std::printf("%-12s %-30s %-13s %5s %-5s %10s  %s\n", "offset", "name", "type", "slots", "unit", "resolution",
              "meaning");
  for (const firmware::RegisterEntry& entry : firmware::register_entries) {
    const int last = entry.address + entry.slots * firmware::words_of(entry.type) - 1;
    const std::string span =
        last == entry.address ? std::to_string(last) : std::to_string(entry.address) + "-" + std::to_string(last);
    std::printf("%-12s %-30s %-13s %5d %-5s %10g  %s\n", span.c_str(), entry.name,
                firmware::register_type_name(entry.type), entry.slots, entry.unit, entry.resolution, entry.doc);
  }
}

void print_json() {
  nlohmann::json map{{"map_version", firmware::register_map_version}, {"registers", nlohmann::json::array()}};
  for (const firmware::RegisterEntry& entry : firmware::register_entries) {
    map["registers"].push_back({{"name", entry.name},
                                {"offset", entry.address},
                                {"type", firmware::register_type_name(entry.type)},
                                {"slots", entry.slots},
                                {"unit", entry.unit},
                                {"resolution", entry.resolution},
                                {"access", entry.command ? "read-write" : "read"},
                                {"meaning", entry.doc}});
  }
  std::printf("%s\n", map.dump(1).c_str());
}

}  // namespace

void add_registers(CLI::App& app) {
  CLI::App* command = app.add_subcommand("registers", "Print the Modbus register map of spindle-twind");
  const auto options = std::make_shared<RegistersOptions>();
  CLI::Option* markdown = command->add_flag("--markdown", options->markdown, "as documentation");
  CLI::Option* csv = command->add_flag("--csv", options->csv, "as import list for a PLC, one row per value");
  CLI::Option* json = command->add_flag("--json", options->json, "as JSON");
  markdown->excludes(csv)->excludes(json);
  csv->excludes(json);
  command->callback([options] {
    if (options->markdown) {
      std::fputs(firmware::register_map_markdown(), stdout);
    } else if (options->csv) {
      std::fputs(firmware::register_map_csv(), stdout);
    } else if (options->json) {
      print_json();
    } else {
      print_table();
    }
  });
}

}  // namespace spindle_twin::host_tools

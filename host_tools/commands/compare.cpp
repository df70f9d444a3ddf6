#include "host_tools/replay/compare.hpp"

#include <spdlog/fmt/fmt.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/pages/fill_page.hpp"
#include "host_tools/pages/page_texts.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/units.hpp"

// spindle-twin compare reference.rom day.csv --correction none --to-correction estimator --html compared.html
namespace spindle_twin::host_tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_points = 3000;  // of a curve on the page

struct CompareCommand {
  ReplayOptions first, second;
  std::string log;
  std::string page;
  bool json = false;
};

ReplayedLog replayed_log(const ReplayOptions& options, const std::string& path) {
  const rom::Network network = rom::read_network(options.network);
  const Log log = read_log(path, network, options.longest_gap_s);
  const firmware::CyclePlan plan = plan_replay(network, log, options);
  std::string name = fmt::format("{}, {}", options.network, law_of(plan));
  for (const std::string& part : {options.calibration, options.config}) {
    if (!part.empty()) name += ", " + part;
  }
  if (!options.sensors.empty()) name += fmt::format(", sensors {}", fmt::join(options.sensors, " "));
  return {name, predicted_courses(network, plan, log)};
}

Json misfit_json(const Misfit& misfit, const std::string& unit, double scale) {
  return {
      {"rms_" + unit, scale * misfit.rms}, {"worst_" + unit, scale * misfit.worst}, {"worst_at_s", misfit.worst_at_s}};
}

Json outputs_json(const std::vector<ComparedOutput>& outputs, const std::string& unit, double scale) {
  Json list = Json::array();
  for (const ComparedOutput& output : outputs) {
    Json entry{{"name", output.name}, {"difference", misfit_json(output.difference, unit, scale)}};
    entry["first_error"] = output.first_error ? misfit_json(*output.first_error, unit, scale) : Json();
    entry["second_error"] = output.second_error ? misfit_json(*output.second_error, unit, scale) : Json();
    list.push_back(entry);
  }
  return list;
}

Json summary_json(const CompareCommand& command, const Comparison& comparison, const ReplayedLog& first,
                  const ReplayedLog& second) {
  return {{"log", command.log},
          {"first", first.name},
          {"second", second.name},
          {"cycles", comparison.time_s.size()},
          {"deformations", outputs_json(comparison.deformations, "um", rom::um_per_m)},
          {"key_points", outputs_json(comparison.key_points, "K", 1.0)}};
}

/// Every so many values: each the last one that is known since the one before.
Json curve(const std::vector<double>& values, std::size_t every, double scale, double shift) {
  Json list = Json::array();
  for (std::size_t i = 0; i < values.size(); i += every) {
    Json known;
    for (std::size_t k = i + 1 > every ? i + 1 - every : 0; k <= i; ++k) {
      if (std::isfinite(values[k])) known = std::round(1e4 * (scale * values[k] + shift)) / 1e4;
    }
    list.push_back(known);
  }
  return list;
}

void add_curves(const std::vector<ComparedOutput>& outputs, std::size_t every, double scale, double shift, Json& list) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const ComparedOutput& output = outputs[i];
    list[i]["measured"] = curve(output.measured, every, scale, shift);
    list[i]["first_off"] = curve(output.first_off, every, scale, 0.0);
    list[i]["second_off"] = curve(output.second_off, every, scale, 0.0);
    list[i]["first"] = curve(output.first, every, scale, shift);
    list[i]["first_sd"] = curve(output.first_deviation, every, scale, 0.0);
    list[i]["second"] = curve(output.second, every, scale, shift);
    list[i]["second_sd"] = curve(output.second_deviation, every, scale, 0.0);
  }
}

Json page_data(Json data, const Comparison& comparison) {
  const std::size_t every = comparison.time_s.size() / most_points + 1;
  data["time_s"] = curve(comparison.time_s, every, 1.0, 0.0);
  add_curves(comparison.deformations, every, rom::um_per_m, 0.0, data["deformations"]);
  add_curves(comparison.key_points, every, 1.0, -rom::zero_degC_K, data["key_points"]);
  return data;
}

void print_outputs(const char* title, const std::vector<ComparedOutput>& outputs, double scale) {
  if (outputs.empty()) return;
  std::printf("\n%-28s %12s %12s %12s %12s %12s\n", title, "first rms", "second rms", "apart rms", "apart worst",
              "at s");
  for (const ComparedOutput& output : outputs) {
    std::printf("%-28s", output.name.c_str());
    for (const auto& error : {output.first_error, output.second_error}) {
      error ? std::printf(" %12.3f", scale * error->rms) : std::printf(" %12s", "");
    }
    std::printf(" %12.3f %12.3f %12.0f\n", scale * output.difference.rms, scale * output.difference.worst,
                output.difference.worst_at_s);
  }
}

void run_compare(const CompareCommand& command) {
  if (!command.page.empty()) rom::check_writable(command.page, "--html");
  ReplayOptions second = command.second;
  const auto same = [](std::string& of_second, const std::string& of_first) {
    if (of_second.empty()) of_second = of_first;
  };
  same(second.network, command.first.network);
  same(second.config, command.first.config);
  if (second.correction.empty() && command.second.config.empty()) second.correction = command.first.correction;
  if (second.sensors.empty() && second.config.empty()) second.sensors = command.first.sensors;
  second.start_degC = command.first.start_degC;
  second.longest_gap_s = command.first.longest_gap_s;
  const ReplayedLog of_first = replayed_log(command.first, command.log);
  const ReplayedLog of_second = replayed_log(second, command.log);
  const rom::Network network = rom::read_network(command.first.network);
  const Log log = read_log(command.log, network, command.first.longest_gap_s);
  const Comparison comparison = compare(network, log, of_first, of_second);
  const Json summary = summary_json(command, comparison, of_first, of_second);
  if (!command.page.empty()) {
    rom::write_whole_file(command.page, fill_page(compare_page_text, page_data(summary, comparison)));
  }
  if (command.json) {
    std::printf("%s\n", summary.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    return;
  }
  std::printf("first:  %s\nsecond: %s\n", of_first.name.c_str(), of_second.name.c_str());
  print_outputs("deformation, um", comparison.deformations, rom::um_per_m);
  print_outputs("key point, K", comparison.key_points, 1.0);
}

/// What one of both may be run with; `begin`: of the options' names.
void add_replay_options(CLI::App& command, const std::string& begin, ReplayOptions& replay) {
  command.add_option(begin + "correction", replay.correction, "none, paper or estimator")
      ->check(CLI::IsMember({"none", "paper", "estimator"}));
  CLI::Option* config = command.add_option(begin + "config", replay.config, "the daemon's configuration");
  command.add_option(begin + "sensors", replay.sensors, "key points that the correction is given, with commas between")
      ->delimiter(',')
      ->excludes(config);
  command.add_option(begin + "calibration", replay.calibration, "that the estimator begins with")->excludes(config);
}

}  // namespace

void add_compare(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "compare",
      "Replay a log twice, with two networks, corrections or calibrations, and show both and the difference");
  const auto options = std::make_shared<CompareCommand>();
  command->add_option("network", options->first.network, "network file, .rom")->required();
  command->add_option("log", options->log, "as for replay")->required();
  add_replay_options(*command, "--", options->first);
  command
      ->add_option("--to", options->second.network,
                   "the second network; what is not said of the second is as the first")
      ->type_name("NETWORK");
  add_replay_options(*command, "--to-", options->second);
  command->add_option("--start-degC", options->first.start_degC, "of the whole spindle; else the sensors' mean")
      ->check(finite_range(-50.0, 300.0, "-50 to 300 degC"));
  command->add_option("--longest-gap-s", options->first.longest_gap_s, "between two rows of the log")
      ->capture_default_str()
      ->check(finite_range(0.01, 1e6, "0.01 to 1e6 s"));
  command->add_option("--html", options->page, "page to write: both, and the difference");
  command->add_flag("--json", options->json, "as JSON");
  command->callback([options] { run_compare(*options); });
}

}  // namespace spindle_twin::host_tools

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/commands/plausibility.hpp"
#include "host_tools/replay/errors.hpp"
#include "host_tools/replay/plan.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/units.hpp"

// spindle-twin replay reference.rom day.csv --correction paper -o replayed.csv
namespace spindle_twin::host_tools {
namespace {

using Json = nlohmann::ordered_json;
using firmware::fault_codes;
using firmware::state_codes;

struct ReplayCommand {
  ReplayOptions replay;
  std::string log;
  std::optional<std::int64_t> run;
  std::string output;
  double from_s = -1e300;
  bool json = false;
  Plausibility plausibility;
};

struct Tally {
  std::size_t cycles = 0;
  std::array<std::size_t, state_codes.size()> in_state{};    ///< in the order of state_codes
  std::array<std::size_t, fault_codes.size()> with_fault{};  ///< in the order of fault_codes
  unsigned corrections = 0;

  void add(const firmware::Snapshot& snapshot) {
    ++cycles;
    for (std::size_t s = 0; s < state_codes.size(); ++s) {
      if (firmware::bits(snapshot.state) == state_codes[s].value) ++in_state[s];
    }
    for (std::size_t f = 0; f < fault_codes.size(); ++f) {
      if ((snapshot.fault & fault_codes[f].value) != 0) ++with_fault[f];
    }
    corrections = snapshot.correction_count;
  }
};

double percent(std::size_t part, std::size_t whole) {
  return 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

Json statistics_json(const ErrorStatistics& errors, const std::string& unit, double scale, double rise) {
  if (errors.count == 0) return {};
  Json json{{"rms_" + unit, scale * errors.rms()},
            {"worst_" + unit, scale * errors.worst},
            {"worst_at_s", errors.worst_at_s},
            {"last_" + unit, scale * errors.last}};
  json["rms_percent_of_rise"] = rise > 0.0 ? Json(100.0 * errors.rms() / rise) : Json();
  return json;
}

Json errors_json(const std::vector<OutputErrors>& outputs, const std::string& unit, double scale) {
  Json list = Json::array();
  for (const OutputErrors& output : outputs) {
    Json entry{{"name", output.name}, {"readings", output.twin.count}, {"rise_" + unit, scale * output.rise()}};
    entry["used"] = output.used;
    entry["twin"] = statistics_json(output.twin, unit, scale, output.rise());
    if (output.with_deviation > 0) {
      entry["sd_" + unit] = scale * output.deviation();
      entry["within_2_sd_percent"] = percent(output.within_2_deviations, output.with_deviation);
    }
    entry["uncorrected"] = statistics_json(output.uncorrected, unit, scale, output.rise());
    list.push_back(entry);
  }
  return list;
}

void print_json(const ReplayCommand& options, const rom::Network& network, const firmware::CyclePlan& plan,
                const Log& log, const Tally& tally, const ReplayErrors& errors) {
  Json json{{"spindle", network.spindle},
            {"log", options.log},
            {"log_is_history", log.cycle_s.has_value()},
            {"correction", law_of(plan)},
            {"log_s", log.rows.back().time_s - log.rows.front().time_s},
            {"period_s", plan.period_s},
            {"cycles", tally.cycles},
            {"corrections", tally.corrections}};
  for (std::size_t s = 0; s < state_codes.size(); ++s) json["states"][state_codes[s].name] = tally.in_state[s];
  for (std::size_t f = 0; f < fault_codes.size(); ++f) json["faults"][fault_codes[f].name] = tally.with_fault[f];
  json["sensors"] = errors_json(errors.sensors(), "K", 1.0);
  json["deformations"] = errors_json(errors.deformations(), "um", rom::um_per_m);
  std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

void print_errors(const char* title, const std::vector<OutputErrors>& outputs, double scale) {
  if (outputs.empty()) return;
  std::printf("\n%-28s %8s %8s %9s %9s %9s %9s %9s %9s %16s\n", title, "readings", "rise", "rms", "worst", "last",
              "of rise", "1 sigma", "within 2", "uncorrected rms");
  for (const OutputErrors& output : outputs) {
    std::printf("%-28s %8zu", output.name.c_str(), output.twin.count);
    if (output.twin.count > 0) {
      std::printf(" %8.2f %9.3f %9.3f %9.3f", scale * output.rise(), scale * output.twin.rms(),
                  scale * output.twin.worst, scale * output.twin.last);
      output.rise() > 0.0 ? std::printf(" %7.1f %%", 100.0 * output.twin.rms() / output.rise())
                          : std::printf(" %9s", "");
      output.with_deviation > 0 ? std::printf(" %9.3f %7.1f %%", scale * output.deviation(),
                                              percent(output.within_2_deviations, output.with_deviation))
                                : std::printf(" %9s %9s", "", "");
      if (output.uncorrected.count > 0) std::printf(" %16.3f", scale * output.uncorrected.rms());
    }
    std::printf("\n");
  }
}

void print_table(const ReplayCommand& options, const rom::Network& network, const firmware::CyclePlan& plan,
                 const Log& log, const Tally& tally, const ReplayErrors& errors) {
  std::printf("%s, %s: %g s, %zu cycles of %g s, correction %s\n", network.spindle.c_str(), options.log.c_str(),
              log.rows.back().time_s - log.rows.front().time_s, tally.cycles, plan.period_s, law_of(plan));
  std::printf("cycles:");
  for (std::size_t s = 0; s < state_codes.size(); ++s) {
    if (tally.in_state[s] > 0) std::printf(" %s %zu", state_codes[s].name, tally.in_state[s]);
  }
  if (tally.corrections > 0) std::printf("; corrections %u", tally.corrections);
  std::printf("\n");
  for (std::size_t f = 0; f < fault_codes.size(); ++f) {
    if (tally.with_fault[f] > 0) std::printf("fault %s in %zu cycles\n", fault_codes[f].name, tally.with_fault[f]);
  }
  print_errors("sensor, error in K", errors.sensors(), 1.0);
  print_errors("deformation, error in um", errors.deformations(), rom::um_per_m);
}

/// Of the key points; none before the prediction has begun.
Eigen::VectorXd predicted_K(const firmware::Snapshot& snapshot) {
  const bool begun = snapshot.state != firmware::State::starting;
  return Eigen::Map<const Eigen::VectorXd>(snapshot.predicted_K.data(),
                                           begun ? static_cast<Eigen::Index>(snapshot.key_points) : 0);
}

void run_replay(const ReplayCommand& options) {
  if (!options.output.empty()) rom::check_writable(options.output, "--output");
  const rom::Network network = rom::read_network(options.replay.network);
  const Log log = read_log(options.log, network, options.replay.longest_gap_s, options.run);
  Plausibility plausibility = options.plausibility;
  plausibility.note_log(log, network);
  const firmware::CyclePlan plan = plan_replay(network, log, options.replay);
  plausibility.note_readings(log, network, plan);
  ReplayErrors errors(network, plan, log, options.from_s);
  Tally tally;
  std::string table = replay_header(network) + "\n";
  replay(network, plan, log, [&](const ReplayedCycle& cycle) {
    const std::vector<double>& error_K = errors.add(cycle);
    tally.add(cycle.snapshot);
    plausibility.add_temperatures(options.replay.network, network.boundaries, predicted_K(cycle.snapshot));
    if (!options.output.empty()) table.append(replay_row(cycle.snapshot, error_K)).append("\n");
  });
  plausibility.note_temperatures(options.replay.network, network.boundaries);
  if (!options.output.empty()) rom::write_whole_file(options.output, table);
  options.json ? print_json(options, network, plan, log, tally, errors)
               : print_table(options, network, plan, log, tally, errors);
}

}  // namespace

void add_replay(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "replay", "Run a log through the daemon's own cycle and compare predictions with what was measured");
  const auto options = std::make_shared<ReplayCommand>();
  ReplayOptions& replay = options->replay;
  command->add_option("network", replay.network, "network file, .rom")->required();
  command->add_option("log", options->log, "a history of spindle-twind (CSV or SQLite), or any CSV with its columns")
      ->required();
  command->add_option("--run", options->run,
                      "of a history in SQLite, as `spindle-twin history` lists them; else the last");
  command
      ->add_option("--correction", replay.correction,
                   "none, paper or estimator; else as the configuration says, without it estimator")
      ->check(CLI::IsMember({"none", "paper", "estimator"}));
  CLI::Option* config = command->add_option("--config", replay.config,
                                            "the daemon's configuration: its sensors, limits, periods and options");
  command
      ->add_option("--sensors", replay.sensors, "key points that the correction is given; the log's others only judge")
      ->delimiter(',')
      ->excludes(config);
  command->add_option("--period", replay.period_s, "of a cycle, s; else a history's own, else 1 s")
      ->excludes(config)
      ->check(finite_range(0.01, 60.0, "0.01 to 60 s"));
  command->add_option("--start-degC", replay.start_degC, "of the whole spindle; else the mean of the first readings")
      ->check(finite_range(-50.0, 300.0, "-50 to 300 degC"));
  const auto of_estimator = [&](const char* name, std::optional<double>& value, const char* text, double least,
                                double most, const char* range) {
    command->add_option(name, value, text)->excludes(config)->check(finite_range(least, most, range));
  };
  of_estimator("--floor-K", replay.floor_K, "what the network itself may be off at a sensor, 1 sigma, K", 0.0, 10.0,
               "0 to 10 K");
  of_estimator("--offset-K", replay.offset_deviation_K, "constant error of each sensor, 1 sigma, K", 1e-4, 10.0,
               "1e-4 to 10 K");
  of_estimator("--lag-s", replay.lag_s, "lag of each sensor, s", 0.0, 600.0, "0 to 600 s");
  of_estimator("--start-K", replay.start_K, "how far the start temperature may be off, 1 sigma, K", 0.0, 10.0,
               "0 to 10 K");
  command->add_option("--health", replay.health, "whether sensors that fail are left out: on (default) or off")
      ->excludes(config)
      ->check(CLI::IsMember({"on", "off"}));
  command
      ->add_option("--calibration", replay.calibration,
                   "of `spindle-twin calibrate`, which the estimator begins with; else as the configuration says")
      ->excludes(config);
  command->add_option("--longest-gap-s", replay.longest_gap_s, "between two rows, and how long a reading counts")
      ->capture_default_str()
      ->check(finite_range(0.01, 1e6, "0.01 to 1e6 s"));
  command->add_option("--from-s", options->from_s, "errors count from this time of the log on")
      ->check(finite_range(-1e12, 1e12, "-1e12 to 1e12 s"));
  command->add_option("-o,--output", options->output, "CSV to write, a row per cycle");
  command->add_flag("--json", options->json, "as JSON");
  options->plausibility.add_to(*command);
  command->callback([options] { run_replay(*options); });
}

}  // namespace spindle_twin::host_tools

#include "correction/calibrate/calibrate.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/calibrate/calibration_page.hpp"
#include "host_tools/calibrate/leave_out_spikes.hpp"
#include "host_tools/calibrate/read_thermal_test.hpp"
#include "host_tools/calibrate/test_options.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/commands/plausibility.hpp"
#include "host_tools/pages/fill_page.hpp"
#include "host_tools/pages/page_texts.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/units.hpp"

// spindle-twin calibrate reference.rom warm_up.csv -o machine7.calibration
namespace spindle_twin::host_tools {
namespace {

constexpr int does_not_fit = 3;

struct CalibrateCommand {  // NOLINT(public-members): a member per option
  std::string network;
  std::vector<std::string> logs;
  std::string config;
  std::string output;
  std::string page;
  std::optional<double> start_degC;
  double longest_gap_s = 60.0;
  double probe_noise_um = 1.0;
  double held_out_um = 2.0;
  int starts = 5;
  bool accept = false;
  bool json = false;
  Plausibility plausibility;
};

bool is_probe(const correction::CalibrateOptions& options, const correction::ChannelFit& channel) {
  return channel.channel >= static_cast<int>(options.sensors.size());
}

nlohmann::ordered_json channels_json(const correction::CalibrateOptions& options,
                                     const std::vector<correction::ChannelFit>& channels) {
  auto list = nlohmann::ordered_json::array();
  for (const correction::ChannelFit& channel : channels) {
    const bool probe = is_probe(options, channel);
    const double scale = probe ? rom::um_per_m : 1.0;
    const std::string unit = probe ? "_um" : "_K";
    list.push_back({{"name", channel.name},
                    {"log", channel.test + 1},
                    {"readings", channel.readings},
                    {"rms" + unit, scale * channel.rms},
                    {"expected_rms" + unit, scale * channel.expected_rms},
                    {"autocorrelation", channel.lag_1},
                    {"outliers", channel.outliers}});
    if (!channel.held_out) continue;
    list.back()["mean" + unit] = scale * channel.held_out->off;
    list.back()["mean_deviation" + unit] = scale * channel.held_out->deviation;
  }
  return list;
}

/// Readings that the fit is not given: the daemon did not believe them, or they stand alone.
struct LeftOut {
  std::string log, sensor;
  int readings = 0;
};

/// Says them to stderr, so that a fit with fewer readings than a person counts surprises nobody.
void add_left_out(const rom::Network& network, const Log& log, std::vector<LeftOut>& list) {
  const std::vector<int> count = readings_left_out(network, log);
  for (std::size_t k = 0; k < count.size(); ++k) {
    if (count[k] == 0) continue;
    list.push_back({log.file, network.key_points[k].name, count[k]});
    std::fprintf(stderr, "%s: %d readings of %s are left out, which the daemon did not believe\n", log.file.c_str(),
                 count[k], network.key_points[k].name.c_str());
  }
}

void add_spikes(const std::vector<Spikes>& spikes, const Log& log, std::vector<LeftOut>& list) {
  for (const Spikes& each : spikes) {
    list.push_back({log.file, each.channel, each.readings});
    std::fprintf(stderr,
                 "%s: %d readings of %s are left out, which stand alone among their neighbours (the first at %g s)\n",
                 log.file.c_str(), each.readings, each.channel.c_str(), each.first_s);
  }
}

void print_json(const correction::CalibrateOptions& options, const std::vector<LeftOut>& left_out,
                const correction::CalibrationResult& result) {
  const correction::Calibration& calibration = result.calibration;
  nlohmann::ordered_json json{{"spindle", calibration.spindle},
                              {"logs", calibration.logs},
                              {"tested_s", calibration.tested_s},
                              {"evaluations", result.fit.evaluations},
                              {"chi_square_per_reading", result.fit.chi_square_per_reading},
                              {"promised_um", rom::um_per_m * calibration.promised_m},
                              {"untested_um", rom::um_per_m * result.untested_m},
                              {"fits", result.misfits.empty()},
                              {"misfits", result.misfits},
                              {"hints", result.hints},
                              {"start_seed", options.start_seed}};
  json["left_out"] = nlohmann::ordered_json::array();
  for (const LeftOut& each : left_out) {
    json["left_out"].push_back({{"log", each.log}, {"sensor", each.sensor}, {"readings", each.readings}});
  }
  for (const correction::StartedFit& start : result.starts) {
    json["starts"].push_back({{"cost", start.cost}, {"apart", start.apart}, {"other_minimum", start.is_other}});
  }
  json["asked_heats"] = nlohmann::ordered_json::array();
  for (const correction::AskedHeat& heat : result.asked) {
    json["asked_heats"].push_back({{"group", heat.group}, {"heat_W", heat.heat_W}, {"deviation_W", heat.deviation_W}});
  }
  for (std::size_t i = 0; i < calibration.names.size(); ++i) {
    const auto slot = static_cast<Eigen::Index>(i);
    const double deviation = calibration.root.row(slot).norm();
    json["parameters"].push_back({{"name", calibration.names[i]},
                                  {"prior", calibration.prior_mean[slot]},
                                  {"prior_deviation", calibration.prior_deviation[slot]},
                                  {"value", calibration.mean[slot]},
                                  {"deviation", deviation},
                                  {"determined", correction::is_determined(calibration, slot)}});
  }
  json["channels"] = channels_json(options, result.fit.channels);
  if (result.held_out.heat) {
    const auto& [before, after] = *result.held_out.heat;
    json["held_out_heat"] = {{"group", before.group},
                             {"before_W", before.heat_W},
                             {"before_deviation_W", before.deviation_W},
                             {"last_quarter_W", after.heat_W},
                             {"last_quarter_deviation_W", after.deviation_W}};
  }
  json["held_out"] = channels_json(options, result.held_out.channels);
  std::printf("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

void print_channels(const char* title, const correction::CalibrateOptions& options,
                    const std::vector<correction::ChannelFit>& channels) {
  const bool are_held_out = !channels.empty() && channels.front().held_out;
  std::printf("\n%-44s %8s %10s %10s %9s %9s%s\n", title, "readings", "rms", "expected", "lag 1", "outliers",
              are_held_out ? "      mean        +-" : "");
  for (const correction::ChannelFit& channel : channels) {
    const bool probe = is_probe(options, channel);
    const double scale = probe ? rom::um_per_m : 1.0;
    const std::string name = fmt::format("{}, log {} [{}]", channel.name, channel.test + 1, probe ? "um" : "K");
    std::printf("%-44s %8zu %10.3f %10.3f %9.2f %9zu", name.c_str(), channel.readings, scale * channel.rms,
                scale * channel.expected_rms, channel.lag_1, channel.outliers);
    if (channel.held_out) {
      std::printf(" %9.3f %9.3f", scale * channel.held_out->off, scale * channel.held_out->deviation);
    }
    std::printf("\n");
  }
}

void print_starts(const correction::CalibrateOptions& options, const std::vector<correction::StartedFit>& starts) {
  double farthest = 0.0;
  std::size_t others = 0;
  for (const correction::StartedFit& start : starts) {
    farthest = std::max(farthest, start.apart);
    others += start.is_other ? 1 : 0;
  }
  if (starts.size() < 2) return;
  std::printf("%zu starts (seed %llu), no parameter ends further than %.1f of its deviations from the best\n",
              starts.size(), static_cast<unsigned long long>(options.start_seed), farthest);
  for (std::size_t k = 0; others > 0 && k < starts.size(); ++k) {
    if (!starts[k].is_other) continue;
    std::printf(
        "  start %zu ends elsewhere, about as good (cost +%.2f, %.1f deviations away): "
        "the deviations above cover both\n",
        k + 1, starts[k].cost, starts[k].apart);
  }
}

void print_table(const correction::CalibrateOptions& options, const correction::CalibrationResult& result) {
  const correction::Calibration& calibration = result.calibration;
  std::printf("%s, %.2f h of test\n\n%-44s %8s %9s %8s %9s\n", calibration.spindle.c_str(),
              calibration.tested_s / rom::seconds_per_hour, "parameter, ln of a factor where no unit stands", "before",
              "+-", "after", "+-");
  std::size_t open = 0;
  for (std::size_t i = 0; i < calibration.names.size(); ++i) {
    const auto slot = static_cast<Eigen::Index>(i);
    const double deviation = calibration.root.row(slot).norm();
    const bool determined = correction::is_determined(calibration, slot);
    open += determined ? 0 : 1;
    std::printf("%-46s %8.3f %9.3f %8.3f %9.3f%s\n", calibration.names[i].c_str(), calibration.prior_mean[slot],
                calibration.prior_deviation[slot], calibration.mean[slot], deviation,
                determined ? "" : "  not determined");
  }
  std::printf("\n%zu of %zu parameters are not determined by this test.\n", open, calibration.names.size());
  print_channels("what the fit leaves of", options, result.fit.channels);
  print_channels("last quarter, predicted from the rest", options, result.held_out.channels);
  std::printf("mean: without what contacts and probe had wandered by before; rms: with it\n");
  std::printf("\nchi-square per reading %.2f (1: model and readings are as good as assumed)\n",
              result.fit.chi_square_per_reading);
  print_starts(options, result.starts);
  if (!result.asked.empty()) {
    const correction::AskedHeat& surest = result.asked.front();
    std::printf("heat that no source explains, the surest: %.1f W +- %.1f W in %s\n", surest.heat_W, surest.deviation_W,
                surest.group.c_str());
  }
  if (result.held_out.heat) {
    const auto& [before, after] = *result.held_out.heat;
    std::printf("  before the last quarter: %.1f W +- %.1f W in %s; in the last quarter: %.1f W +- %.1f W\n",
                before.heat_W, before.deviation_W, before.group.c_str(), after.heat_W, after.deviation_W);
  }
  if (calibration.promised_m > 0.0) {
    std::printf(
        "promised after 4 h at the described operating state, without a sensor: nose within %.2f um (1 sigma, drift "
        "since the test included); without this test %.2f um\n",
        rom::um_per_m * calibration.promised_m, rom::um_per_m * result.untested_m);
  }
  std::printf("%s\n", result.misfits.empty() ? "It fits." : "It does not fit:");
  for (const std::string& misfit : result.misfits) std::printf("  %s\n", misfit.c_str());
  for (const std::string& hint : result.hints) std::printf("  hint: %s\n", hint.c_str());
}

/// The same instants and sensor readings, bit for bit.
bool is_the_same(const correction::ThermalTest& a, const correction::ThermalTest& b) {
  return a.time_s == b.time_s && a.measured_K.size() == b.measured_K.size() &&
         std::equal(a.measured_K.data(), a.measured_K.data() + a.measured_K.size(), b.measured_K.data(),
                    [](double one, double other) { return one == other || (std::isnan(one) && std::isnan(other)); });
}

void run_calibrate(const CalibrateCommand& command) {
  if (!command.output.empty()) rom::check_writable(command.output, "--output");
  if (!command.page.empty()) rom::check_writable(command.page, "--html");
  const rom::RomFile file = rom::read_rom_file(command.network);
  Plausibility plausibility = command.plausibility;
  std::vector<correction::ThermalTest> tests;
  std::vector<LeftOut> left_out;
  for (const std::string& name : command.logs) {
    const Log log = read_log(name, file.network, command.longest_gap_s);
    plausibility.note_log(log, file.network);
    plausibility.note_measured(log, file.network);
    correction::ThermalTest test = read_thermal_test(file.network, log, command.start_degC);
    add_spikes(leave_out_spikes(file.network, command.probe_noise_um * rom::m_per_um, test), log, left_out);
    for (const correction::ThermalTest& before : tests) {
      if (!is_the_same(before, test)) continue;
      throw rom::InputError({name, 0}, "logs", "holds the readings of " + before.name + ": they would count twice");
    }
    tests.push_back(std::move(test));
    add_left_out(file.network, log, left_out);
  }
  correction::CalibrateOptions options = test_options(file.network, command.config);
  options.probe_noise_m = command.probe_noise_um * rom::m_per_um;
  options.starts = command.starts;
  correction::CalibrateLimits limits;
  limits.held_out_m = command.held_out_um * rom::m_per_um;
  const bool shows = isatty(STDERR_FILENO) == 1;
  correction::CalibrationResult result =
      correction::calibrate(file.network, options, tests, limits, [&](const char* what, int count) {
        if (shows) std::fprintf(stderr, "\r%s: the model has run %d times ", what, count);
      });
  if (shows) std::fprintf(stderr, "\r%60s\r", "");
  if (plausibility.has_warned()) {
    result.misfits.emplace_back("what a log says is not plausible: see the warnings");
    result.calibration.accepted = false;
  }
  result.calibration.network_sha256 = file.sha256;
  result.calibration.made_unix_s = static_cast<double>(std::time(nullptr));
  command.json ? print_json(options, left_out, result) : print_table(options, result);
  if (!command.page.empty()) {
    rom::write_whole_file(command.page,
                          fill_page(calibration_page_text, calibration_page_data(file.network, options, result)));
  }
  if (!result.misfits.empty() && !command.accept) {
    std::fprintf(stderr, "spindle-twin calibrate: it does not fit, so nothing is written; --accept writes it\n");
    throw CLI::RuntimeError(does_not_fit);
  }
  if (!command.output.empty()) correction::write_calibration(result.calibration, command.output);
}

}  // namespace

void add_calibrate(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "calibrate", "Fit heats, contacts, films and laws of one machine to whole logs of a test, best with a probe");
  const auto options = std::make_shared<CalibrateCommand>();
  command->add_option("network", options->network, "network file, .rom")->required();
  command
      ->add_option("logs", options->logs,
                   "CSV or history of the daemon, one a test: sensors and measured.<deformation>_um of a probe")
      ->required();
  command->add_option("--config", options->config, "the daemon's configuration: its priors, noise, offsets and lags");
  command->add_option("--start-degC", options->start_degC, "of the whole spindle; else the mean of the first readings")
      ->check(finite_range(-50.0, 300.0, "-50 to 300 degC"));
  command->add_option("--longest-gap-s", options->longest_gap_s, "between two rows of a log")
      ->capture_default_str()
      ->check(finite_range(0.01, 1e6, "0.01 to 1e6 s"));
  command->add_option("--probe-noise-um", options->probe_noise_um, "of one reading of a probe or touch-off")
      ->capture_default_str()
      ->check(finite_range(0.01, 100.0, "0.01 to 100 um"));
  command->add_option("--held-out-um", options->held_out_um, "most rms of a probe in the last quarter, predicted")
      ->capture_default_str()
      ->check(finite_range(0.01, 1000.0, "0.01 to 1000 um"));
  command
      ->add_option("--starts", options->starts,
                   "points from which the fit begins: where a fit of the first three quarters ended, then seeded draws "
                   "of the priors")
      ->capture_default_str()
      ->check(CLI::Range(1, 50));
  command->add_option("--html", options->page,
                      "write a page: readings, model before and after, what is left, +-2 sigma");
  command->add_flag("--accept", options->accept, "write it although it does not fit");
  command->add_option("-o,--output", options->output, "calibration to write, for [correction] calibration");
  command->add_flag("--json", options->json, "as JSON");
  options->plausibility.add_to(*command);
  command->callback([options] { run_calibrate(*options); });
}

}  // namespace spindle_twin::host_tools

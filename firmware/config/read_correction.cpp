#include "firmware/config/read_correction.hpp"

#include <algorithm>
#include <utility>

#include "firmware/config/load_network.hpp"
#include "firmware/config/read_files.hpp"
#include "rom/read/options.hpp"

namespace spindle_twin::firmware {
namespace {

/// The priors of the table, and what a calibration knows better.
void read_priors(const rom::TomlTable& correction, Config& config, correction::EstimatorPriors& priors) {
  if (const auto table = correction.optional_table("prior")) rom::read_options(*table, priors);
  const std::optional<std::string> file = correction.optional_string("calibration");
  correction::DriftOptions drift;
  if (const auto table = correction.optional_table("drift")) {
    rom::read_options(*table, drift);
  }
  config.cycle.drift = drift;
  if (!file) return;
  const std::string path = beside(config.path, *file);
  check_is_there(path, correction.where("calibration"), correction.path("calibration"));
  correction::CalibrationFile read = correction::read_calibration_file(path);
  check_signature(config.network,
                  {path, read.signed_by, correction.where("calibration"), correction.path("calibration")});
  config.calibration = ConfiguredCalibration{path, std::move(read.calibration)};
  priors.calibrated = prior_of(config.calibration->calibration, drift);
}

void read_estimator(const rom::TomlTable& table, Config& config) {
  correction::EstimatorOptions& options = config.cycle.estimator.emplace();
  const double shortest_s = std::max(1.0, config.cycle.period_s);
  options.period_s = std::max(options.period_s, shortest_s);
  correction::EstimatorOptions::each(options,
                                     rom::ReadOptions(table).narrow("period_s", rom::between(shortest_s, 60.0)));
  read_priors(table, config, options.priors);
}

void read_paper(const rom::TomlTable& table, Config& config) {
  correction::PaperOptions& paper = config.cycle.paper.emplace();
  correction::PaperOptions::each(
      paper, rom::ReadOptions(table).narrow("period_s", rom::between(config.cycle.period_s, 86400.0)));
  if (paper.window_s > paper.period_s) table.fail("window_s", "must be at most period_s");
  if (const auto guards = table.optional_table("guards")) {
    correction::PaperGuards::each(
        paper.guards, rom::ReadOptions(*guards).narrow("minimum_sensors",
                                                       rom::between(1.0, static_cast<double>(config.sensors.size()))));
  }
  for (const rom::TomlTable& group : table.tables_or_empty("group")) {
    const std::string name = group.name();
    group.show_as(name);
    config.groups.push_back(
        {name, group.where(), group.path("sensors"), group.strings("sensors"), group.strings("sources")});
  }
}

}  // namespace

void read_correction(const std::optional<rom::TomlTable>& table, Config& config) {
  const std::string otherwise = config.sensors.empty() ? "none" : "estimator";
  const std::string law = table ? table->choice_or("law", otherwise, {"estimator", "paper", "none"}) : otherwise;
  config.cycle.estimator_corrects = law == "estimator";
  if (law == "none") {
    // It stands by for ever: how far the model can be trusted without correction follows from the same priors.
    correction::EstimatorOptions& options = config.cycle.estimator.emplace();
    if (table) read_priors(*table, config, options.priors);
    if (!config.calibration) return;
    if (!config.sensors.empty()) {
      table->fail("law",
                  "\"none\" leaves the model as it is described; a calibration needs \"estimator\", or no [[sensor]]");
    }
    config.cycle.estimator_corrects = true;  // the calibrated model, without a reading
    options.period_s = std::max(options.period_s, config.cycle.period_s);
    config.cycle.correction_enabled = table->boolean_or("enabled", true);
    return;
  }
  if (config.sensors.empty()) table->fail("law", "\"" + law + "\" needs at least one [[sensor]]");
  if (!table) {
    config.cycle.estimator.emplace().period_s = std::max(10.0, config.cycle.period_s);
    return;
  }
  config.cycle.correction_enabled = table->boolean_or("enabled", true);
  if (law == "paper") {
    read_paper(*table, config);
  } else {
    read_estimator(*table, config);
  }
}

}  // namespace spindle_twin::firmware

#include "firmware/config/read_correction.hpp"

#include <algorithm>

namespace spindle_twin::firmware {
namespace {

constexpr rom::Range below_one{0.0, 1.0, false, true};
constexpr rom::Range above_one{1.0, 1e6, true, false};

void read_guards(const rom::TomlTable& table, correction::PaperGuards& guards) {
  guards.reading_uncertainty_K =
      table.number_or("reading_uncertainty_K", guards.reading_uncertainty_K, rom::not_negative);
  guards.minimum_rise_K = table.number_or("minimum_rise_K", guards.minimum_rise_K, rom::not_negative);
  guards.step_minimum = table.number_or("step_minimum", guards.step_minimum, below_one);
  guards.step_maximum = table.number_or("step_maximum", guards.step_maximum, above_one);
  guards.heat_minimum = table.number_or("heat_minimum", guards.heat_minimum, below_one);
  guards.heat_maximum = table.number_or("heat_maximum", guards.heat_maximum, above_one);
  guards.resistance_minimum =
      table.number_or("resistance_minimum", guards.resistance_minimum, rom::Range{0.001, 1.0, false, true});
  guards.resistance_maximum = table.number_or("resistance_maximum", guards.resistance_maximum, above_one);
  guards.resistance_step = table.number_or("resistance_step", guards.resistance_step, above_one);
  guards.minimum_sensors =
      static_cast<int>(table.integer_or("minimum_sensors", guards.minimum_sensors, 1, slots::key_points));
  guards.settle_s = table.number_or("settle_s", guards.settle_s, rom::not_negative);
  guards.speed_change_rpm = table.number_or("speed_change_rpm", guards.speed_change_rpm, rom::not_negative);
  guards.load_change = table.number_or("load_change", guards.load_change, rom::not_negative);
  guards.standstill_rpm = table.number_or("standstill_rpm", guards.standstill_rpm, rom::not_negative);
  guards.deadband = table.boolean_or("deadband", guards.deadband);
}

/// A standard deviation or the like: none at all, or one that a covariance can hold.
double zero_or_some(const rom::TomlTable& table, const char* key, double otherwise, double most) {
  constexpr double least = 1e-9;
  const double value = table.number_or(key, otherwise, rom::between(0.0, most));
  if (value > 0.0 && value < least) table.fail(key, "must be 0 or at least 1e-9");
  return value;
}

correction::EstimatorPriors read_priors(const rom::TomlTable& table) {
  constexpr double ln_deviation = 2.0;
  correction::EstimatorPriors priors;
  priors.heat = zero_or_some(table, "heat", priors.heat, ln_deviation);
  priors.heat_common = zero_or_some(table, "heat_common", priors.heat_common, ln_deviation);
  priors.contact = zero_or_some(table, "contact", priors.contact, ln_deviation);
  priors.film = zero_or_some(table, "film", priors.film, ln_deviation);
  priors.environment_K = zero_or_some(table, "environment_K", priors.environment_K, 10.0);
  priors.environment_memory_s = zero_or_some(table, "environment_memory_s", priors.environment_memory_s, 1e9);
  priors.bearing_mean_per_K = zero_or_some(table, "bearing_mean_per_K", priors.bearing_mean_per_K, 0.1);
  priors.bearing_per_K = zero_or_some(table, "bearing_per_K", priors.bearing_per_K, 0.1);
  priors.speed_exponent = zero_or_some(table, "speed_exponent", priors.speed_exponent, 1.0);
  priors.start_K = zero_or_some(table, "start_K", priors.start_K, 100.0);
  priors.start_shape_K = zero_or_some(table, "start_shape_K", priors.start_shape_K, 100.0);
  priors.disturbance = zero_or_some(table, "disturbance", priors.disturbance, 1.0);
  priors.disturbance_by_hand = zero_or_some(table, "disturbance_by_hand", priors.disturbance_by_hand, 1.0);
  priors.disturbance_memory_s =
      table.number_or("disturbance_memory_s", priors.disturbance_memory_s, rom::between(60.0, 1e9));
  priors.capacity = zero_or_some(table, "capacity", priors.capacity, 1.0);
  priors.heat_walk_per_root_min = zero_or_some(table, "heat_walk_per_root_min", priors.heat_walk_per_root_min, 1.0);
  priors.contact_walk_per_root_min =
      zero_or_some(table, "contact_walk_per_root_min", priors.contact_walk_per_root_min, 1.0);
  priors.film_walk_per_root_min = zero_or_some(table, "film_walk_per_root_min", priors.film_walk_per_root_min, 1.0);
  priors.centred = table.boolean_or("centred", priors.centred);
  return priors;
}

void read_estimator(const rom::TomlTable& table, Config& config) {
  correction::EstimatorOptions& options = config.cycle.estimator.emplace();
  const double shortest_s = std::max(1.0, config.cycle.period_s);
  options.period_s =
      table.number_or("period_s", std::max(options.period_s, shortest_s), rom::between(shortest_s, 60.0));
  options.noise_K = table.number_or("noise_K", options.noise_K, noise_range_K);
  options.offset_K = table.number_or("offset_K", options.offset_K, offset_range_K);
  options.lag_s = table.number_or("lag_s", options.lag_s, lag_range_s);
  options.lag_deviation_s = zero_or_some(table, "lag_deviation_s", options.lag_deviation_s, 120.0);
  options.floor_K = zero_or_some(table, "floor_K", options.floor_K, 10.0);
  options.floor_by_hand_K = zero_or_some(table, "floor_by_hand_K", options.floor_by_hand_K, 10.0);
  options.floor_largest_K = zero_or_some(table, "floor_largest_K", options.floor_largest_K, 100.0);
  options.correlation_s = zero_or_some(table, "correlation_s", options.correlation_s, 3600.0);
  options.offset_walk_K_per_root_hour =
      zero_or_some(table, "offset_walk_K_per_root_hour", options.offset_walk_K_per_root_hour, 1.0);
  options.gate = table.number_or("gate", options.gate, rom::between(1.0, 1000.0));
  if (const auto priors = table.optional_table("prior")) options.priors = read_priors(*priors);
}

void read_paper(const rom::TomlTable& table, Config& config) {
  correction::PaperOptions& paper = config.cycle.paper.emplace();
  paper.period_s = table.number_or("period_s", paper.period_s, rom::between(config.cycle.period_s, 86400.0));
  paper.window_s = table.number_or("window_s", paper.window_s, rom::between(0.0, paper.period_s));
  paper.relaxation = table.number_or("relaxation", paper.relaxation, {0.0, 1.0, true, false});
  paper.state_rescale = table.boolean_or("state_rescale", paper.state_rescale);
  paper.heat_law = table.boolean_or("heat_law", paper.heat_law);
  paper.joint_law = table.boolean_or("joint_law", paper.joint_law);
  paper.joint_exponent = table.number_or("joint_exponent", paper.joint_exponent, rom::between(0.0, 1.0));
  if (const auto guards = table.optional_table("guards")) read_guards(*guards, paper.guards);
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
    const auto priors = table ? table->optional_table("prior") : std::nullopt;
    if (priors) options.priors = read_priors(*priors);
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

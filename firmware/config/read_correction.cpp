#include "firmware/config/read_correction.hpp"

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

}  // namespace

void read_correction(const rom::TomlTable& table, Config& config) {
  const std::string law = table.choice("law", {"paper", "none"});
  if (law == "none") return;
  if (config.sensors.empty()) table.fail("law", "\"paper\" needs at least one [[sensor]]");
  config.cycle.correction_enabled = table.boolean_or("enabled", true);
  correction::PaperOptions paper;
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
  config.cycle.paper = paper;
}

}  // namespace spindle_twin::firmware

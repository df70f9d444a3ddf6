#include "firmware/config/read_compensation.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "firmware/config/find_by_name.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

using rom::m_per_um;
constexpr double m_per_mm = 1e-3;
constexpr double warning_share = 0.8;  // of the limit
constexpr rom::Range length_um{0.0, 1e4, true, false};

void read_along(const rom::TomlTable& table, Config& config) {
  CompensationPlan& plan = config.cycle.compensation;
  plan.reference_m = m_per_mm * table.number_or("reference_mm", 0.0, rom::between(-1e5, 1e5));
  if (!table.has("other")) return;
  config.compensation.other = table.string("other");
  config.compensation.where = table.where("other");
  plan.distance_m = m_per_mm * table.number("distance_mm", rom::between(-1e5, 1e5));
  if (plan.distance_m == 0.0) table.fail("distance_mm", "must not be 0");
}

void read_forecast(const rom::TomlTable& table, Config& config) {
  ForecastPlan& plan = config.cycle.forecast;
  const double stride_min = Forecast::stride_s / rom::seconds_per_minute;
  const double most_min = Forecast::strides * stride_min;
  const double ahead_min = table.number_or("look_ahead_min", 0.0, rom::between(0.0, most_min));
  if (std::fmod(ahead_min, stride_min) != 0.0) table.fail("look_ahead_min", "must be a multiple of 5");
  plan.ahead_s = rom::seconds_per_minute * ahead_min;
  plan.settled_m = m_per_um * table.number_or("settled_um", plan.settled_m / m_per_um, length_um);
}

}  // namespace

void read_compensation(const std::optional<rom::TomlTable>& table, Config& config) {
  CompensationPlan& plan = config.cycle.compensation;
  plan.slew_m_per_s = config.cycle.slew_m_per_s;
  // A stride of the forecast each second of the clock, however fast the cycles are.
  const double cycle_s = config.cycle.period_s / config.cycle.clock_rate;
  config.cycle.forecast.every_cycles = static_cast<std::size_t>(std::max(1.0, std::round(1.0 / cycle_s)));
  if (!table) return;
  plan.enabled = table->boolean_or("enabled", plan.enabled);
  plan.sign = static_cast<double>(table->integer_or("sign", 1, -1, 1));
  if (plan.sign == 0.0) table->fail("sign", "must be 1 or -1");
  plan.slew_m_per_s = m_per_um * table->number_or("slew_um_per_s", plan.slew_m_per_s / m_per_um, rom::positive);
  plan.step_m = m_per_um * table->number_or("step_um", 0.0, rom::between(0.0, 100.0));
  config.compensation.step_where = table->where("step_um");
  if (table->has("limit_um")) config.compensation.limit_m = m_per_um * table->number("limit_um", length_um);
  if (table->has("warning_um")) {
    config.compensation.warning_m = m_per_um * table->number("warning_um", length_um);
    config.compensation.warning_where = table->where("warning_um");
  }
  plan.on_loss = table->choice_or("on_loss", "decay", {"hold", "decay"}) == "hold" ? OnLoss::hold : OnLoss::decay;
  plan.hold_s = rom::seconds_per_minute *
                table->number_or("hold_min", plan.hold_s / rom::seconds_per_minute, rom::between(0.0, 10080.0));
  plan.decay_s = rom::seconds_per_minute *
                 table->number_or("decay_min", plan.decay_s / rom::seconds_per_minute, rom::between(0.1, 10080.0));
  read_along(*table, config);
  read_forecast(*table, config);
}

void bind_compensation(const Config& config, const rom::Network& network, CyclePlan& plan) {
  CompensationPlan& to = plan.compensation;
  const ConfiguredCompensation& from = config.compensation;
  to.limit_m = from.limit_m.value_or(plan.output_limit_m[0]);
  to.warning_m = from.warning_m.value_or(warning_share * to.limit_m);
  if (to.warning_m > to.limit_m) {
    throw rom::InputError(from.warning_where, "compensation.warning_um",
                          fmt::format("must be at most the limit, {:g} um, or it never comes", to.limit_m / m_per_um));
  }
  if (to.step_m > to.limit_m) {
    throw rom::InputError(
        from.step_where, "compensation.step_um",
        fmt::format("must be at most the limit, {:g} um, or nothing ever moves", to.limit_m / m_per_um));
  }
  if (from.other.empty()) return;
  to.other = find_by_name(network.deformations, from.other, "deformation output", from.where, "compensation.other");
  if (to.other == 0) {
    throw rom::InputError(from.where, "compensation.other",
                          "\"" + from.other + "\" is the first output, which is compensated itself");
  }
}

}  // namespace spindle_twin::firmware

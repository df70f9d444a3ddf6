#include "firmware/config/read_health.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr double most_K = 100.0;
constexpr double most_s = 86400.0;

void read_limits(const rom::TomlTable& table, correction::HealthLimits& limits) {
  const auto kelvin = [&](const char* key, double& value) {
    value = table.number_or(key, value, rom::between(1e-3, most_K));
  };
  const auto seconds = [&](const char* key, double& value) {
    value = table.number_or(key, value, rom::between(1.0, most_s));
  };
  const auto ratio = [&](const char* key, double& value) {
    value = table.number_or(key, value, rom::between(1e-3, 1000.0));
  };
  limits.open_above_K =
      zero_degC_K + table.number_or("open_above_degC", limits.open_above_K - zero_degC_K, rom::between(100.0, 1e4));
  limits.short_below_K =
      zero_degC_K + table.number_or("short_below_degC", limits.short_below_K - zero_degC_K, rom::between(-273.0, 0.0));
  kelvin("jump_K", limits.jump_K);
  limits.jump_share = table.number_or("jump_share", limits.jump_share, rom::between(0.0, 100.0));
  limits.spikes = static_cast<int>(table.integer_or("spikes", limits.spikes, 1, 16));
  seconds("spike_window_s", limits.spike_window_s);
  kelvin("stuck_K", limits.stuck_K);
  seconds("stuck_window_s", limits.stuck_window_s);
  ratio("drift_limit", limits.drift_limit);
  ratio("drift_lead", limits.drift_lead);
  limits.rejected = static_cast<int>(table.integer_or("rejected", limits.rejected, 1, 100000));
  kelvin("swap_K", limits.swap_K);
  ratio("swap_limit", limits.swap_limit);
  seconds("return_after_s", limits.return_after_s);
  kelvin("return_offset_K", limits.return_offset_K);
  limits.failures = static_cast<int>(table.integer_or("failures", limits.failures, 1, 1000));
}

void read_tare(const rom::TomlTable& table, CyclePlan& plan) {
  correction::TareLimits& limits = plan.tare;
  limits.rest_s = table.number_or("rest_s", limits.rest_s, rom::between(60.0, 1e6));
  limits.block_s = table.number_or("block_s", limits.block_s, rom::between(10.0, most_s));
  limits.rate_K_per_h = table.number_or("rate_K_per_h", limits.rate_K_per_h, rom::between(1e-3, most_K));
  limits.spread_K = table.number_or("spread_K", limits.spread_K, rom::between(1e-3, most_K));
  limits.model_spread_K = table.number_or("model_spread_K", limits.model_spread_K, rom::between(1e-3, most_K));
  plan.tare_to_ambient = table.choice_or("reference", "mean", {"mean", "ambient"}) == "ambient";
}

}  // namespace

void read_health(const std::optional<rom::TomlTable>& table, Config& config) {
  if (!table) return;
  CyclePlan& plan = config.cycle;
  correction::HealthLimits limits;
  read_limits(*table, limits);
  plan.return_within_K = table->number_or("return_within_K", plan.return_within_K, rom::between(1e-3, most_K));
  if (const auto tare = table->optional_table("tare")) read_tare(*tare, plan);
  plan.health.reset();
  if (table->boolean_or("enabled", true)) plan.health = limits;
}

}  // namespace spindle_twin::firmware

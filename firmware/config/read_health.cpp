#include "firmware/config/read_health.hpp"

#include "rom/read/options.hpp"

namespace spindle_twin::firmware {

void read_health(const std::optional<rom::TomlTable>& table, Config& config) {
  if (!table) return;
  CyclePlan& plan = config.cycle;
  correction::HealthLimits limits;
  rom::read_options(*table, limits);
  plan.return_within_K = table->number_or("return_within_K", plan.return_within_K, rom::between(1e-3, 100.0));
  if (const auto tare = table->optional_table("tare")) {
    rom::read_options(*tare, plan.tare);
    plan.tare_to_ambient = tare->choice_or("reference", "mean", {"mean", "ambient"}) == "ambient";
  }
  plan.health.reset();
  if (table->boolean_or("enabled", true)) plan.health = limits;
}

}  // namespace spindle_twin::firmware

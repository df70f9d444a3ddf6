#include "firmware/config/read_exchange.hpp"

#include <filesystem>
#include <system_error>

#include "firmware/config/read_files.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {

void read_exchange(const std::optional<rom::TomlTable>& table, Config& config) {
  if (!table) return;
  ConfiguredExchange& exchange = config.exchange;
  exchange.slot = beside(config.path, table->string("slot"));
  std::error_code unknown;
  if (!std::filesystem::is_directory(exchange.slot, unknown)) {
    table->fail("slot", "\"" + exchange.slot + "\" is not a folder; it must be there, and the daemon may write in it");
  }
  const std::filesystem::path network = beside(config.path, config.network.path);
  const std::filesystem::path folder = network.has_parent_path() ? network.parent_path() : ".";
  if (std::filesystem::equivalent(folder, exchange.slot, unknown)) {
    table->fail("slot",
                "is the folder of the network itself, which would be tried and removed; it must be another one");
  }
  if (config.network.trusted_keys.empty()) {
    table->fail("slot", "network.trusted_keys must name at least one key: only signed networks are taken from a slot");
  }
  ExchangePlan& plan = exchange.plan;
  constexpr auto minutes = rom::between(0.5, 10080.0);
  plan.trial_s =
      rom::seconds_per_minute * table->number_or("trial_min", plan.trial_s / rom::seconds_per_minute, minutes);
  plan.watch_s =
      rom::seconds_per_minute * table->number_or("watch_min", plan.watch_s / rom::seconds_per_minute, minutes);
  plan.margin = table->number_or("margin", plan.margin, rom::between(0.0, 10.0));
  plan.margin_K = table->number_or("margin_K", plan.margin_K, rom::between(0.0, 10.0));
}

}  // namespace spindle_twin::firmware

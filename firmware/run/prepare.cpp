#include "firmware/run/prepare.hpp"

#include <exception>
#include <utility>

#include "firmware/config/load_network.hpp"

namespace spindle_twin::firmware {
namespace {

/// A number that passed for itself may still be none together with the others, or with this network.
Cycle make_cycle(const Config& config, const rom::Network& network, const CyclePlan& plan) {
  try {
    const auto shared = std::make_shared<const rom::NetworkOperator>(network);
    return {network, plan, [&](const rom::Network&) { return rom::make_runtime_stepper(shared); }, shared};
  } catch (const std::exception& error) {
    throw rom::InputError({config.path, 0}, "correction, health", error.what());
  }
}

}  // namespace

PreparedSpindle::PreparedSpindle(ConfiguredSpindle configured)
    : name(std::move(configured.name)),
      unit(configured.unit),
      config(std::move(configured.config)),
      file(load_network(config.network)),
      plan(bind_config(config, file.network)),
      cycle(make_cycle(config, file.network, plan.cycle)) {}

std::unique_ptr<PreparedSpindle> prepare(ConfiguredSpindle configured) {
  return std::make_unique<PreparedSpindle>(std::move(configured));
}

std::string signer(const rom::RomFile& file) {
  return file.signed_by ? "signed by " + rom::to_hex(*file.signed_by) : "not signed";
}

}  // namespace spindle_twin::firmware

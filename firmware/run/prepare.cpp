#include "firmware/run/prepare.hpp"

#include <exception>
#include <utility>
#include <vector>

#include "firmware/config/load_network.hpp"
#include "firmware/keep/state_files.hpp"

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

template <class Items>
std::string names_of(const Items& items) {
  std::string names;
  for (const auto& item : items) names.append(names.empty() ? "" : ", ").append(item.name);
  return names;
}

/// Registers, history, orders and configuration mean things by their places: these must stay what they are.
void check_names(const rom::Network& runs, const rom::Network& comes, const std::string& path) {
  const auto check = [&](const char* field, const std::string& has, const std::string& allowed) {
    if (has == allowed) return;
    throw rom::InputError({path, 0}, field,
                          "is \"" + has + "\"; allowed is what the network that runs has, \"" + allowed + "\"");
  };
  check("spindle", comes.spindle, runs.spindle);
  check("key points", names_of(comes.key_points), names_of(runs.key_points));
  check("parts", names_of(comes.parts), names_of(runs.parts));
  check("deformations", names_of(comes.deformations), names_of(runs.deformations));
  const rom::Boundaries& has = comes.boundaries;
  const rom::Boundaries& allowed = runs.boundaries;
  check("heat sources", names_of(has.sources), names_of(allowed.sources));
  check("contacts and films", names_of(has.conductances), names_of(allowed.conductances));
  check("surroundings", names_of(has.environments), names_of(allowed.environments));
  check("coolant circuits", names_of(has.circuits), names_of(allowed.circuits));
  const auto measured = [](const rom::Boundaries& boundaries) {
    std::string names;
    for (const rom::HeatSource& source : boundaries.sources) names += source.measured ? source.name + ", " : "";
    return names;
  };
  check("measured heats", measured(has), measured(allowed));
}

/// What the parameters' table and the checkpoint list.
std::string parameters_of(const Cycle& cycle) {
  return cycle.parameters() == nullptr ? "" : names_of(cycle.parameters()->list());
}

std::string in_slot(const PreparedSpindle& spindle, const char* what) {
  constexpr std::size_t digits = 16;
  return spindle.config.exchange.slot + "/" + what + "-" + spindle.configured_sha256.substr(0, digits) + ".rom";
}

/// Of the network that the accepted one took the place of; a previous one that cannot be read is nobody's.
std::string sha256_before(const PreparedSpindle& spindle) {
  const std::string previous = previous_path(spindle);
  try {
    return exists_as_file(previous) ? rom::read_rom_file(previous).sha256 : spindle.configured_sha256;
  } catch (const rom::InputError&) {
    return {};
  }
}

}  // namespace

PreparedSpindle::PreparedSpindle(ConfiguredSpindle configured)
    : name(std::move(configured.name)),
      unit(configured.unit),
      config(std::move(configured.config)),
      file(load_network(config.network)),
      plan(bind_config(config, file.network)),
      cycle(make_cycle(config, file.network, plan.cycle)) {
  configured_sha256 = file.sha256;
  cycle.identify(file.sha256);
}

std::unique_ptr<PreparedSpindle> prepare_with(const PreparedSpindle& spindle, const std::string& path) {
  ConfiguredSpindle other{spindle.name, spindle.unit, spindle.config};
  other.config.network.path = path;
  other.config.network.require_signature = true;
  auto prepared = std::make_unique<PreparedSpindle>(std::move(other));
  check_names(spindle.file.network, prepared->file.network, path);
  if (parameters_of(spindle.cycle) != parameters_of(prepared->cycle)) {
    throw rom::InputError({path, 0}, "parameters of the correction",
                          "are \"" + parameters_of(prepared->cycle) +
                              "\"; allowed are those of the network that runs, \"" + parameters_of(spindle.cycle) +
                              "\"");
  }
  prepared->configured_sha256 = spindle.configured_sha256;
  return prepared;
}

std::unique_ptr<PreparedSpindle> prepare(ConfiguredSpindle configured) {
  auto spindle = std::make_unique<PreparedSpindle>(std::move(configured));
  if (spindle->config.exchange.slot.empty()) return spindle;
  const std::string accepted = accepted_path(*spindle);
  try {
    if (!exists_as_file(accepted)) return spindle;
    auto taken = prepare_with(*spindle, accepted);
    taken->sha256_before = sha256_before(*spindle);
    return taken;
  } catch (const std::exception& error) {
    spindle->note = std::string(error.what()) + "; it was accepted before, now the configured network runs";
    return spindle;
  }
}

std::string accepted_path(const PreparedSpindle& spindle) { return in_slot(spindle, "accepted"); }
std::string previous_path(const PreparedSpindle& spindle) { return in_slot(spindle, "previous"); }

std::string signer(const rom::RomFile& file) {
  return file.signed_by ? "signed by " + rom::to_hex(*file.signed_by) : "not signed";
}

}  // namespace spindle_twin::firmware

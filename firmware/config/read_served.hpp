#pragma once

#include <optional>
#include <string>

#include "firmware/config/listeners.hpp"
#include "firmware/plant/plant_plan.hpp"
#include "firmware/serve/serve_plan.hpp"
#include "firmware/show/show_plan.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// What the daemon has once, however many spindles it runs. Each throws rom::InputError with file, line and field.

/// `log_level`; "info" where it is missing.
std::string read_log_level(const rom::TomlTable& root);
/// [serve] with [serve.tls], whose files stand relative to `config_path`; but for the keys that a spindle has for
/// itself.
ServePlan read_serve(const rom::TomlTable& table, const std::string& config_path, Listeners& listeners);
/// [http]; without that table nobody listens.
ShowPlan read_http(const rom::TomlTable& root, const std::string& config_path, Listeners& listeners);
/// [plant] with [plant.tls], whose files stand relative to `config_path`; without that table nothing is published.
PlantPlan read_plant(const std::optional<rom::TomlTable>& table, const std::string& config_path);

}  // namespace spindle_twin::firmware

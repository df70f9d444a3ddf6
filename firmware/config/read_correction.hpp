#pragma once

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// What the estimator can be told of a sensor.
inline constexpr rom::Range noise_range_K = rom::between(1e-4, 10.0);
inline constexpr rom::Range offset_range_K = rom::between(1e-4, 10.0);
inline constexpr rom::Range lag_range_s = rom::between(0.0, 600.0);

/// The [correction] table: law, options, priors, guards and groups, into config.cycle and config.groups. Without the
/// table the estimator corrects where there are sensors.
void read_correction(const std::optional<rom::TomlTable>& table, Config& config);

}  // namespace spindle_twin::firmware

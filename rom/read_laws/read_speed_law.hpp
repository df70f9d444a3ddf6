#pragma once

#include "rom/boundaries.hpp"
#include "rom/read/strict_toml.hpp"
#include "rom/units.hpp"

namespace spindle_twin::rom {

/// Allowed range of every temperature in a file.
inline constexpr Range temperature_degC{-zero_degC_K, 1000.0, true, false};

/// The table `speed_law` of `owner`, constant 1 without it: { constant ? 0, speed_terms ? [[coefficient, exponent],
/// ...], load_squared ? 0, zero_at_standstill ? false }, all >= 0. Throws InputError unless constant, coefficients and
/// load_squared add up to 1, the value at the reference state.
SpeedLaw read_speed_law(const TomlTable& owner);

/// `friction` of a heat whose law is `law`: whether it is friction of a bearing, which falls as the bearing warms.
/// Without the key, is_friction_unless_said(law).
bool read_friction(const TomlTable& heat, const SpeedLaw& law);

}  // namespace spindle_twin::rom

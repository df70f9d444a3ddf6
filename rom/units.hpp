#pragma once

namespace spindle_twin::rom {

// Between SI, which all names of values without a unit of their own mean, and what people read and write.

inline constexpr double zero_degC_K = 273.15;  ///< 0 degC in kelvin: T_K = T_degC + zero_degC_K
inline constexpr double um_per_m = 1e6;
inline constexpr double m_per_um = 1e-6;
inline constexpr double seconds_per_minute = 60.0;
inline constexpr double seconds_per_hour = 3600.0;

}  // namespace spindle_twin::rom

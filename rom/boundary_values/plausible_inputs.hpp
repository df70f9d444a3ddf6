#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "rom/boundaries.hpp"
#include "rom/range.hpp"

namespace spindle_twin::rom {

/// What is believed of a spindle's inputs. Outside it a value is more likely a mistake (percent for a share, kelvin for
/// degC, rad/s for rpm) than a state of the spindle.
struct PlausibleInputs {
  Range speed_rpm;
  Range load;
  std::vector<Range> environment_K;  ///< one per environment
  std::vector<Range> flow_kg_per_s;  ///< one per circuit; any number where the description has no flow
  std::vector<Range> heat_W;         ///< one per measured heat; any number where the description has none
};

/// speed     up to twice the fastest of the description's speeds and of `certified_rpm`, that of the certificate
/// load      up to 3 times the rated one, either way
/// coolant   within 25 K of the description's, ambient within 30 K
/// flow      up to 5 times the description's, either way
/// a measured heat  up to 5 times the description's; as noise, half of it the other way
/// A limit is any number where the description's own value is 0. Ranges of Boundaries::plausible take the place of
/// these, here and below.
PlausibleInputs plausible_inputs(const Boundaries& boundaries, double certified_rpm = 0.0);

/// A value that is not believed.
struct Implausible {
  std::string field;                            ///< as a schedule's column names it, or what of the description
  std::string message;                          ///< the value, what is believed, and which mistake it may be
  std::optional<std::size_t> conductance = {};  ///< that it is of, if it is of one
};

/// Of one value; none where it lies in the range. `unit` may say which mistake is likely.
std::optional<Implausible> judge_value(double value, Range believed, const std::string& field, const std::string& unit);

/// Of the inputs at one instant.
std::vector<Implausible> implausible_inputs(const Boundaries& boundaries, const PlausibleInputs& believed,
                                            const OperatingState& state);

/// Of what a description says at its operating state: films beyond 0.1 to 50,000 W/m²K (still air in a narrow gap,
/// boiling water), contacts beyond 1 to 1,000,000 W/m²K, and heats that together would warm `capacity_J_per_K`, all of
/// the spindle, by more than 1 K/s if nothing left it.
std::vector<Implausible> implausible_description(const Boundaries& boundaries, double capacity_J_per_K);

/// Of the temperatures that came out: beyond -40 to 300 degC, where neither grease nor windings live.
std::vector<Implausible> implausible_temperatures(const Boundaries& boundaries, double coldest_K, double hottest_K);

}  // namespace spindle_twin::rom

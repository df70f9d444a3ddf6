#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/schedule.hpp"

/// A simulated spindle whose temperatures come from the FE model itself, with a truth that no twin is told.
namespace spindle_twin::host_tools {

/// NAME=VALUE as given on the command line; NAME may be "all".
struct NamedValue {
  std::string name;
  double value = 1.0;
};

/// Reads "name=1.5"; throws rom::InputError naming `option`.
NamedValue parse_named_value(const std::string& text, const std::string& option);

/// Log-uniform factors in [1/factor, factor], one per contact, from a seed.
struct ContactSpread {
  std::uint64_t seed = 0;
  double factor = 1.0;
};

/// Reads "seed:factor", as in 7:2.0; throws rom::InputError.
ContactSpread parse_contact_spread(const std::string& text);

/// What differs between the plant and its description.
struct HiddenTruth {
  std::vector<NamedValue> heat_factors;
  std::vector<NamedValue> contact_factors;
  std::vector<NamedValue> film_factors;
  std::optional<ContactSpread> contact_spread;
  bool joint_law = false;             ///< contacts with a fit follow their pressure (correction/paper/joint_law.hpp)
  double noise_K = 0.0;               ///< standard deviation of one reading
  std::vector<NamedValue> offsets_K;  ///< per key point
  std::uint64_t seed = 1;             ///< of the noise
};

/// Factors on heats and conductances. Throws rom::InputError naming the option and listing the names that exist.
rom::CorrectionFactors hidden_factors(const rom::Boundaries& boundaries, const HiddenTruth& truth);

struct PlantSnapshot {
  double time_s = 0.0;
  std::uint64_t steps = 0;
  rom::OperatingState operating;
  std::vector<double> measured_degC;   ///< key points with noise and offset: what the device shows
  std::vector<double> key_point_degC;  ///< truth
  std::vector<double> part_max_degC;   ///< truth
  std::vector<double> deformation_um;  ///< truth
};

class Plant {
 public:
  /// `model` must outlive this. Everything starts at the description's reference temperature.
  Plant(const fem_offline::AffineModel& model, const HiddenTruth& truth, rom::Schedule schedule);

  /// One step of model time; after the schedule's end its last row holds.
  void advance(double step_s);

  const PlantSnapshot& snapshot() const { return snapshot_; }

 private:
  void observe();
  void update_joints();

  const fem_offline::AffineModel& model_;
  HiddenTruth truth_;
  rom::Schedule schedule_;
  rom::CorrectionFactors hidden_;   ///< constant part
  rom::CorrectionFactors present_;  ///< times the joint law
  rom::BoundaryValues values_;
  fem_offline::FeStepper stepper_;
  std::vector<double> offset_K_;
  std::mt19937_64 random_;
  double joints_due_s_ = 0.0;
  PlantSnapshot snapshot_;
};

/// CSV: one header line, one line per snapshot. Columns: time_s, speed_rpm, load, <environment>_degC,
/// key_point.<name>_degC and measured.<name>_degC, part_maximum.<part>_degC, deformation.<output>_um.
void write_plant_header(std::ostream& out, const fem_offline::AffineModel& model);
void write_plant_row(std::ostream& out, const PlantSnapshot& snapshot);

}  // namespace spindle_twin::host_tools

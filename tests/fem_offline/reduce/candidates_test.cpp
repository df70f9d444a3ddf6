// Points of part extremes: where they stand, a part's hottest place is found whatever the spindle does.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iostream>

#include "coarse_milling.hpp"
#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/dense_model.hpp"
#include "fem_offline/reduce/nodal.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_candidates_test {

const AffineModel& milling() {
  static const FeModel model = coarse_milling(0.008);
  return model.affine();
}

/// How far the hottest of a part's points stays below the part's hottest place, at most, in the minutes after a stop
/// that ends a quarter of an hour at speed: 60 random sets of conductances, speeds and loads, which the points were not
/// chosen by.
double most_missed_K(const RichBasis& basis, const DenseModel& dense, const PartExtremes& extremes, const char* part) {
  const rom::Boundaries& boundaries = milling().boundaries;
  const rom::CoolantSegments segments = rom::coolant_segments(boundaries);
  const auto named = std::find_if(milling().parts.begin(), milling().parts.end(),
                                  [&](const FePart& item) { return item.name == part; });
  const std::vector<int>& points = extremes[static_cast<std::size_t>(named - milling().parts.begin())];
  const Eigen::MatrixXd rows = basis.columns(named->dofs, Eigen::all);
  ReduceOptions options;
  double missed_K = 0.0;
  for (std::uint32_t set = 0; set < 60; ++set) {
    RandomStream random(20261128, StreamPurpose::verification, set);
    rom::CorrectionFactors factors = rom::no_correction(boundaries);
    factors.conductance = random_conductance_factors(boundaries, options.box, false, random);
    rom::BoundaryValues values = rom::make_boundary_values(boundaries);
    HeldModel held;
    Eigen::VectorXd field_K = boundaries.reference_temperature_K * dense.uniform;
    const auto hold = [&](const rom::OperatingState& state) {
      rom::evaluate_boundaries(boundaries, state, factors, values);
      hold_inputs(dense, boundaries, segments, values, 0.0, held);
    };
    const auto step = [&](double step_s) {
      const ShiftedModel shifted(dense, held, 1.0 / step_s);
      field_K = shifted.solve(held.drive + (1.0 / step_s) * (dense.capacity * field_K));
    };
    rom::OperatingState state = boundaries.operating;
    state.speed_rpm = random.uniform(0.5, 1.0) * options.box.speed_high_rpm;
    state.load = random.uniform(0.0, 1.0);
    hold(state);
    step(900.0);
    state.speed_rpm = state.load = 0.0;
    hold(state);
    for (const double step_s : {1.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0}) {
      step(step_s);
      const Eigen::VectorXd part_K = rows * field_K;
      missed_K = std::max(missed_K, part_K.maxCoeff() - part_K(points).maxCoeff());
    }
  }
  return missed_K;
}

/// Under a bearing the shaft is hottest at the contact while the bearing's friction heats it. Behind a stop the contact
/// cools first, and the hottest place moves inwards within seconds.
TEST(PartExtremes, hold_the_maximum_of_a_shaft_whose_spindle_stops) {
  ReduceOptions options;
  options.full_sets = 10;
  options.full_histories = 30;
  options.rich_states = 200;
  options.rich_states_per_body = 0;
  Loads loads = make_loads(milling(), options.box.speed_high_rpm, options.box.load_high);
  const RichBasis basis = full_snapshot_basis(milling(), loads, options, {});
  const DenseModel dense = project_dense(milling(), basis.columns, 1);
  const PartExtremes extremes = find_part_extremes(milling(), basis.columns, dense, options);
  const double missed_K = most_missed_K(basis, dense, extremes, "shaft");
  std::cout << "points miss the shaft's maximum by up to " << missed_K << " K\n";
  EXPECT_LT(missed_K, 0.1);
}

}  // namespace reduce_candidates_test
}  // namespace spindle_twin::fem_offline

#include "fem_offline/reduce/krylov_stepper.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/analysed_system.hpp"
#include "fem_offline/reduce/drive_case.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "grid_model.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_krylov_stepper_test {

SparseMatrix sparse(const Eigen::MatrixXd& dense) { return dense.sparseView(); }

/// One lump of 100 J/K with 2 m2 of film to the room.
AffineModel one_lump() {
  AffineModel model;
  model.capacity_J_per_K = sparse(Eigen::MatrixXd::Constant(1, 1, 100.0));
  model.conduction_W_per_K.resize(1, 1);
  model.conductance_terms_m2 = {sparse(Eigen::MatrixXd::Constant(1, 1, 2.0))};
  model.source_distribution = Eigen::MatrixXd::Ones(1, 1);
  model.places.resize(1);
  rom::Conductance film;
  film.environment = 0;
  model.boundaries.conductances = {film};
  model.boundaries.environments = {{"room", rom::EnvironmentKind::ambient}};
  model.boundaries.sources = {{"heat", 30.0, {}}};
  return model;
}

rom::BoundaryValues of_lump(double film_W_per_m2K, double heat_W, double room_K) {
  rom::BoundaryValues values;
  values.conductance_W_per_m2K = Eigen::VectorXd::Constant(1, film_W_per_m2K);
  values.heat_W = Eigen::VectorXd::Constant(1, heat_W);
  values.environment_K = Eigen::VectorXd::Constant(1, room_K);
  return values;
}

/// The fields at the ends of a stretch's parts.
std::vector<Eigen::VectorXd> fields_K(const AffineModel& model, const std::vector<StretchPart>& parts,
                                      const Eigen::VectorXd& start_K, double tolerance_K) {
  const AnalysedSystem matrices(model);
  KrylovStepper stepper(model, matrices.analysed, tolerance_K);
  stepper.set_temperatures(start_K);
  std::vector<Eigen::VectorXd> found;
  stepper.advance(parts, [&](std::size_t part, const Eigen::VectorXd& field_K) {
    EXPECT_EQ(part, found.size());
    found.push_back(field_K);
  });
  EXPECT_EQ(stepper.temperatures_K(), found.back());
  return found;
}

/// The first stretch of a random case of at least so many parts.
std::vector<StretchPart> stretch_of(const rom::Boundaries& boundaries, std::uint32_t index, std::size_t least) {
  const DriveCase drive = random_case(boundaries, 20261127, index);
  std::vector<StretchPart> parts;
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  for (const HeldInterval& interval : drive.intervals) {
    rom::evaluate_boundaries(boundaries, interval.state, drive.factors, values);
    values.laws.follow = false;
    if (!parts.empty() && !of_one_stretch(parts.front().values, values)) {
      if (parts.size() >= least) break;
      parts.clear();
    }
    parts.push_back({interval.duration_s, values});
  }
  return parts;
}

/// Largest difference from steps in time whose own error is hundreds of times smaller. [K]
double largest_difference_K(const AffineModel& model, const std::vector<StretchPart>& parts, double tolerance_K) {
  const Eigen::VectorXd start_K =
      Eigen::VectorXd::Constant(model.capacity_J_per_K.rows(), model.boundaries.reference_temperature_K + 3.0);
  const std::vector<Eigen::VectorXd> found_K = fields_K(model, parts, start_K, tolerance_K);
  FeStepper steps(model, FeScheme::order_4);
  steps.set_temperatures(start_K);
  double largest_K = 0.0, rise_K = 0.0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    steps.advance_within(parts[i].duration_s, 1e-6, parts[i].values);
    largest_K = std::max(largest_K, (found_K[i] - steps.temperatures_K()).cwiseAbs().maxCoeff());
    rise_K = std::max(rise_K, (found_K[i] - start_K).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(rise_K, 0.1) << "nothing happens in this stretch";
  return largest_K;
}

TEST(KrylovStepper, a_lump_goes_to_its_steady_state_by_its_time_constant) {
  const AffineModel model = one_lump();
  const rom::BoundaryValues values = of_lump(5.0, 30.0, 300.0);
  const std::vector<StretchPart> parts = {{1.0, values}, {1.0, values}, {2.0, values}, {60.0, values}};
  const auto found_K = fields_K(model, parts, Eigen::VectorXd::Constant(1, 280.0), 1e-3);
  double time_s = 0.0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    time_s += parts[i].duration_s;
    EXPECT_NEAR(found_K[i][0], 303.0 - 23.0 * std::exp(-time_s / 10.0), 1e-9);
  }
}

TEST(KrylovStepper, a_room_that_moves_is_held_over_each_part) {
  const AffineModel model = one_lump();
  const std::vector<StretchPart> parts = {
      {10.0, of_lump(5.0, 0.0, 300.0)}, {20.0, of_lump(5.0, 0.0, 301.0)}, {5.0, of_lump(5.0, 0.0, 299.0)}};
  const auto found_K = fields_K(model, parts, Eigen::VectorXd::Constant(1, 310.0), 1e-3);
  const double first_K = 300.0 + 10.0 * std::exp(-1.0), second_K = 301.0 + (first_K - 301.0) * std::exp(-2.0);
  EXPECT_NEAR(found_K[0][0], first_K, 1e-9);
  EXPECT_NEAR(found_K[1][0], second_K, 1e-9);
  EXPECT_NEAR(found_K[2][0], 299.0 + (second_K - 299.0) * std::exp(-0.5), 1e-9);
}

TEST(KrylovStepper, what_is_steady_stays) {
  const AffineModel model = make_grid_model();
  const rom::Boundaries& boundaries = model.boundaries;
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, boundaries.operating, rom::no_correction(boundaries), values);
  const Eigen::VectorXd steady_K = solve_steady(model, values);
  const auto found_K = fields_K(model, {{1.0, values}, {1000.0, values}}, steady_K, 1e-3);
  EXPECT_LT((found_K.back() - steady_K).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(KrylovStepper, every_unknown_is_that_of_fine_steps_to_the_tolerance_in_a_drive_cycle) {
  const AffineModel model = make_grid_model();
  for (const std::uint32_t index : {0U, 1U, 2U}) {
    const auto parts = stretch_of(model.boundaries, index, 8);
    EXPECT_LT(largest_difference_K(model, parts, 2e-3), 2e-3) << "case " << index;
    EXPECT_LT(largest_difference_K(model, parts, 1e-5), 1e-4) << "case " << index;
  }
}

TEST(KrylovStepper, what_a_circuit_carries_is_in_it_whichever_way_it_flows_and_where_it_stands) {
  const FeModel fe = build_fe_model(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/jacket_circuit.toml");
  auto parts = stretch_of(fe.affine().boundaries, 0, 8);
  rom::OperatingState state = fe.affine().boundaries.operating;
  for (const double flow_kg_per_s : {0.08, -0.08, 0.0}) {
    state.flow_kg_per_s.setConstant(flow_kg_per_s);
    rom::BoundaryValues values = rom::make_boundary_values(fe.affine().boundaries);
    rom::evaluate_boundaries(fe.affine().boundaries, state, rom::no_correction(fe.affine().boundaries), values);
    values.laws.follow = false;
    for (StretchPart& part : parts) part.values = values;
    EXPECT_LT(largest_difference_K(fe.affine(), parts, 2e-3), 2e-3) << flow_kg_per_s << " kg/s";
  }
}

TEST(KrylovStepper, what_no_space_of_its_size_can_reach_is_left_to_steps_in_time) {
  const AffineModel model = make_grid_model();
  auto parts = stretch_of(model.boundaries, 1, 8);
  parts.resize(2);
  EXPECT_LT(largest_difference_K(model, parts, 1e-14), 1e-6);
}

TEST(KrylovStepper, what_changes_conductances_heats_or_flows_ends_a_stretch_and_surroundings_do_not) {
  const auto flowing = [](double film_W_per_m2K, double heat_W, double room_K, double flow_W_per_K) {
    rom::BoundaryValues values = of_lump(film_W_per_m2K, heat_W, room_K);
    values.coolant_W_per_K = Eigen::VectorXd::Constant(1, flow_W_per_K);
    return values;
  };
  const rom::BoundaryValues first = flowing(5.0, 30.0, 300.0, 100.0);
  EXPECT_TRUE(of_one_stretch(first, flowing(5.0, 30.0, 310.0, 100.0)));
  EXPECT_FALSE(of_one_stretch(first, flowing(5.1, 30.0, 300.0, 100.0)));
  EXPECT_FALSE(of_one_stretch(first, flowing(5.0, 31.0, 300.0, 100.0)));
  EXPECT_FALSE(of_one_stretch(first, flowing(5.0, 30.0, 300.0, 101.0)));
}

/// Largest difference in any temperature from steps of 0.1 s, in the first intervals of a random case. [K]
double difference_from_short_steps_K(const AffineModel& model, bool drift, std::size_t intervals) {
  const AnalysedSystem matrices(model);
  CaseOptions options;
  options.drift = drift;
  DriveCase drive = random_case(model.boundaries, 20261127, 5, options);
  drive.intervals.resize(std::min(drive.intervals.size(), intervals));
  const Eigen::MatrixXd exact = run_fe_model(model, drive, matrices.analysed).outputs;
  const Eigen::MatrixXd steps = run_fe_model_by_steps(model, drive, 0.1, &matrices.analysed).outputs;
  return (exact - steps).topRows(output_layout(model).deformations_at()).cwiseAbs().maxCoeff();
}

TEST(FeTrajectory, of_a_drive_cycle_is_that_of_short_steps) {
  EXPECT_LT(difference_from_short_steps_K(make_grid_model(), false, 20), 1e-3);
  EXPECT_LT(difference_from_short_steps_K(make_grid_model(), true, 12), 1e-3);
}

TEST(FeTrajectory, goes_from_steps_to_projection_and_back_where_a_large_model_begins_to_drift) {
  const FeModel fe = build_fe_model(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference.toml");
  const AffineModel& model = fe.affine();
  ASSERT_GE(model.capacity_J_per_K.rows(), 3000);
  const AnalysedSystem matrices(model);
  DriveCase drive = random_case(model.boundaries, 20261127, 7, {});
  drive.intervals.resize(16);
  // The first seven intervals, and those from the twelfth on, each with films of their own.
  for (std::size_t i = 0; i < drive.intervals.size(); ++i) {
    if (i >= 7 && i < 12) continue;
    drive.intervals[i].conductance_factors = (1.0 + 1e-3 * static_cast<double>(i)) * drive.factors.conductance;
  }
  const Eigen::MatrixXd found = run_fe_model(model, drive, matrices.analysed).outputs;
  const Eigen::MatrixXd steps = run_fe_model_by_steps(model, drive, 1.0, &matrices.analysed).outputs;
  const Eigen::Index temperatures = output_layout(model).deformations_at();
  EXPECT_LT((found - steps).topRows(temperatures).cwiseAbs().maxCoeff(), 5e-3);
  const Eigen::VectorXd change = (found.rightCols(1) - found.leftCols(1)).cwiseAbs();
  EXPECT_GT(change.head(temperatures).maxCoeff(), 0.5) << "nothing happens in this case";
}

}  // namespace reduce_krylov_stepper_test
}  // namespace spindle_twin::fem_offline

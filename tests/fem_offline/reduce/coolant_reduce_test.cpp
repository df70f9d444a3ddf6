#include <gtest/gtest.h>

#include <iostream>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/verify.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/exact_stepper.hpp"
#include "rom/integrate/outputs.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_coolant_reduce_test {

const AffineModel& jacket() {
  static const FeModel model = build_fe_model(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/jacket_circuit.toml");
  return model.affine();
}

/// 400 W at most: faster, and with standing coolant, the jacket would rise by hundreds of kelvin.
ParameterBox moderate() {
  ParameterBox box;
  box.speed_high_rpm = 6000.0;
  return box;
}

const rom::Network& coolant_network() {
  static const rom::Network built = [] {
    ReduceOptions options;
    options.nodes = 80;
    options.full_sets = 40;
    options.full_histories = 40;
    options.rich_sets = 60;
    options.rich_states = 250;
    options.seed = 3;
    options.box = moderate();
    return reduce_model(jacket(), options);
  }();
  return built;
}

TEST(CoolantNetwork, follows_the_fe_model_while_the_flow_changes_stops_and_turns) {
  VerifyOptions options;
  options.cases = 4;
  options.seed = 11;
  options.drive.box = moderate();
  const VerifyReport report = verify_network(coolant_network(), jacket(), options);
  std::cout << "worst of 4 cases, seed 11: key points " << report.certificate.worst.key_points_K << " K, part maxima "
            << report.certificate.worst.part_max_K << " K, length " << report.certificate.worst.nose_um << " um\n";
  EXPECT_LT(report.certificate.worst.key_points_K, 0.1);
  EXPECT_LT(report.certificate.worst.part_max_K, 0.15);
  EXPECT_LT(report.certificate.worst.nose_um, 0.15);
}

TEST(CoolantNetwork, reaches_the_fe_steady_state) {
  const rom::Boundaries& boundaries = jacket().boundaries;
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, boundaries.operating, rom::no_correction(boundaries), values);
  rom::ExactStepper stepper(std::make_shared<const rom::NetworkOperator>(coolant_network()));
  for (int k = 0; k < 4; ++k) ASSERT_EQ(stepper.advance(1e5, values), rom::StepStatus::ok);
  rom::NetworkOutputs outputs = rom::make_network_outputs(coolant_network());
  rom::evaluate_outputs(coolant_network(), stepper.temperatures_K(), outputs);
  const Eigen::VectorXd full_K = solve_steady(jacket(), values);
  for (std::size_t k = 0; k < jacket().key_points.size(); ++k) {
    EXPECT_NEAR(outputs.key_points_K[static_cast<Eigen::Index>(k)], jacket().key_points[k].row.dot(full_K), 0.01);
  }
}

TEST(CoolantNetwork, cases_stop_and_turn_the_flow) {
  const rom::Boundaries& boundaries = jacket().boundaries;
  const ParameterBox box;
  const double scale_kg_per_s = flow_scale_kg_per_s(boundaries, 0);
  int stopped = 0, turned = 0;
  for (std::uint32_t index = 0; index < 20; ++index) {
    for (const HeldInterval& interval : random_case(boundaries, 5, index).intervals) {
      const double flow_kg_per_s = interval.state.flow_kg_per_s[0];
      ASSERT_LE(std::abs(flow_kg_per_s), box.flow_high * scale_kg_per_s);
      if (flow_kg_per_s == 0.0) ++stopped;
      if (flow_kg_per_s < 0.0) ++turned;
    }
  }
  EXPECT_GT(stopped, 0);
  EXPECT_GT(turned, 0);
}

}  // namespace reduce_coolant_reduce_test
}  // namespace spindle_twin::fem_offline

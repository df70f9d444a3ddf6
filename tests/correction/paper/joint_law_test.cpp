#include <gtest/gtest.h>

#include "correction/paper/joint_law.hpp"
#include "tests/correction/paper/one_node.hpp"

namespace spindle_twin::correction::test {
namespace paper_joint_law_test {

/// Ring of bore 37 mm in ring of outside 50 mm, fit at 40 mm: 0.3109345123991 MPa per um of interference; 4 um at
/// assembly; expansion 1.2e-5 on the fit radius gives 0.48 um per kelvin.
rom::JointFit sleeve_fit() {
  constexpr double pressure_Pa_per_um = 0.3109345123991e6;
  return {4.0 * pressure_Pa_per_um, 0.48 * pressure_Pa_per_um, 0.48 * pressure_Pa_per_um};
}

TEST(JointLaw, resistance_follows_the_fit_pressure) {
  struct Case {
    double rise_K, ratio;
  };
  for (const Case& item : {Case{-2, 1.205165684592}, Case{0, 1.0}, Case{1, 0.9258310559044}, Case{2, 0.8639194547959},
                           Case{5, 0.7264377620196}, Case{10, 0.5849955696378}}) {
    EXPECT_NEAR(joint_resistance_ratio(sleeve_fit(), item.rise_K, 0.0, 0.68, 0.1, 10.0), item.ratio, 1e-12);
    EXPECT_NEAR(joint_resistance_ratio(sleeve_fit(), 3.0 + item.rise_K, 3.0, 0.68, 0.1, 10.0), item.ratio, 1e-12);
  }
}

TEST(JointLaw, lost_pressure_gives_the_largest_resistance_not_a_nan) {
  EXPECT_EQ(joint_resistance_ratio(sleeve_fit(), -9.0, 0.0, 0.68, 0.1, 10.0), 10.0);
  EXPECT_EQ(joint_resistance_ratio(sleeve_fit(), 1e6, 0.0, 0.68, 0.1, 10.0), 0.1);
}

/// Body 0 is the inner, heated one, body 1 the outer one.
rom::Network joined_bodies() {
  rom::Network network = node_network(375.0, 5.0, 2);
  network.boundaries.sources[1].nominal_W = 0.0;
  network.boundaries.conductances[1].fit = sleeve_fit();
  network.boundaries.conductances[1].part_a = 0;
  network.boundaries.conductances[1].part_b = 1;
  return network;
}

struct Fixture {
  explicit Fixture(const PaperOptions& options)
      : network(joined_bodies()),
        correction(network, options, [] { return std::make_unique<NodeStepper>(375.0, 2); }) {}
  void correct_with(double inner_rise_K, double outer_rise_K, double inner_residual_K) {
    Eigen::VectorXd nodes_K(2);
    nodes_K << ambient_K + inner_rise_K, ambient_K + outer_rise_K;
    Eigen::VectorXd predicted_K = Eigen::VectorXd::Constant(6, nodes_K[0]);
    predicted_K.tail(3).setConstant(nodes_K[1]);
    Eigen::VectorXd measured_K = predicted_K;
    measured_K.head(3).array() += inner_residual_K;
    correction.step({time_s, measured_K, valid, predicted_K, nodes_K, network.boundaries.operating}, 80.0);
    time_s += 80.0;
  }
  rom::Network network;
  PaperCorrection correction;
  Eigen::Array<bool, Eigen::Dynamic, 1> valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(6, true);
  double time_s = 0.0;
};

PaperOptions joints_only() {
  PaperOptions options;
  options.window_s = 0.0;
  options.heat_law = false;
  options.guards.resistance_step = 100.0;
  return options;
}

TEST(JointLaw, conductance_factor_is_the_inverse_resistance_and_only_fits_move) {
  Fixture fixture(joints_only());
  fixture.correct_with(5.0, 0.0, 0.0);
  EXPECT_EQ(fixture.correction.factors().conductance[1], 1.0);
  fixture.correct_with(5.0, 0.0, 0.0);
  EXPECT_NEAR(fixture.correction.factors().conductance[1], 1.0 / 0.7264377620196, 1e-11);
  EXPECT_EQ(fixture.correction.factors().conductance[0], 1.0);
}

TEST(JointLaw, sensors_on_a_body_shift_its_mean_rise) {
  Fixture fixture(joints_only());
  fixture.correct_with(4.0, 0.0, 1.0);
  fixture.correct_with(4.0, 0.0, 1.0);
  EXPECT_NEAR(fixture.correction.factors().conductance[1], 1.0 / 0.7264377620196, 1e-11);
  fixture.valid.head(3).setConstant(false);
  fixture.correct_with(2.0, 0.0, 1.0);
  EXPECT_NEAR(fixture.correction.factors().conductance[1], 1.0 / 0.8639194547959, 1e-11);
}

TEST(JointLaw, rate_of_change_is_limited) {
  PaperOptions options = joints_only();
  options.guards.resistance_step = 1.1;
  Fixture fixture(options);
  fixture.correct_with(5.0, 0.0, 0.0);
  fixture.correct_with(5.0, 0.0, 0.0);
  EXPECT_NEAR(fixture.correction.factors().conductance[1], 1.1, 1e-14);
  fixture.correct_with(5.0, 0.0, 0.0);
  EXPECT_NEAR(fixture.correction.factors().conductance[1], 1.21, 1e-14);
}

TEST(JointLaw, switched_off_leaves_the_contacts_alone) {
  PaperOptions options = joints_only();
  options.joint_law = false;
  Fixture fixture(options);
  fixture.correct_with(5.0, 0.0, 0.0);
  fixture.correct_with(5.0, 0.0, 0.0);
  EXPECT_EQ(fixture.correction.factors().conductance[1], 1.0);
}

}  // namespace paper_joint_law_test
}  // namespace spindle_twin::correction::test

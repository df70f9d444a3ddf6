// The reference spindle against an independent solution of the same geometry (linear elements, 67k unknowns).
#include <gtest/gtest.h>

#include "tests/verification/nominal.hpp"

namespace spindle_twin::fem_offline {
namespace reference_spindle_test {

class ReferenceSpindle : public testing::Test {
 protected:
  static void SetUpTestSuite() { model_ = new FeModel(build_fe_model(spindle_file("reference"))); }
  static void TearDownTestSuite() {
    delete model_;
    model_ = nullptr;
  }
  const AffineModel& model() const { return model_->affine(); }
  double ambient_K() const { return model().boundaries.reference_temperature_K; }

 private:
  static FeModel* model_;
};
FeModel* ReferenceSpindle::model_ = nullptr;

TEST_F(ReferenceSpindle, steady_figures) {
  const Eigen::VectorXd rise_K = solve_steady(model(), nominal_values(model())).array() - ambient_K();
  EXPECT_NEAR(part_maximum(model(), "rotor", rise_K), 15.22, 0.05);
  EXPECT_NEAR(part_minimum(model(), "jacket", rise_K), 2.70, 0.02);
  double key_points_K = 0.0;
  for (const FeKeyPoint& point : model().key_points) key_points_K = std::max(key_points_K, point.row.dot(rise_K));
  EXPECT_NEAR(key_points_K, 4.96, 0.03);
  EXPECT_EQ(model().deformations[0].name, "nose");
  EXPECT_NEAR(1e6 * model().deformations[0].row_m_per_K.dot(rise_K), 15.46, 0.08);
}

TEST_F(ReferenceSpindle, uniform_rise_moves_the_nose_by_2_72_um_per_kelvin) {
  const Eigen::VectorXd one_K = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(model().places.size()));
  EXPECT_NEAR(1e6 * model().deformations[0].row_m_per_K.dot(one_K), 2.72, 0.01);
}

TEST_F(ReferenceSpindle, heat_in_is_heat_out) {
  const rom::BoundaryValues values = nominal_values(model());
  const HeatBalance balance = heat_balance(model(), values, solve_steady(model(), values));
  EXPECT_NEAR(balance.heat_in_W, 55.1 + 25.5 + 291.9 + 79.8, 0.1);
  EXPECT_NEAR(balance.heat_out_W, balance.heat_in_W, 1e-9 * balance.heat_in_W);
}

/// Times to 98 % of the final rise: rotor 1170 s, nose 1515 s, key point 2770 s.
TEST_F(ReferenceSpindle, transient_reaches_98_percent_when_the_independent_solution_does) {
  const rom::BoundaryValues values = nominal_values(model());
  const Eigen::VectorXd final_K = solve_steady(model(), values).array() - ambient_K();
  const Eigen::VectorXd& nose = model().deformations[0].row_m_per_K;
  const auto& inner = model().key_points[0].row;
  const double rotor_final_K = part_maximum(model(), "rotor", final_K);
  double rotor_s = 0.0, nose_s = 0.0, key_point_s = 0.0;
  FeStepper stepper(model());
  stepper.set_uniform_temperature(ambient_K());
  for (double time_s = 10.0; time_s <= 4000.0; time_s += 10.0) {
    stepper.advance(10.0, 10.0, values);
    const Eigen::VectorXd rise_K = stepper.temperatures_K().array() - ambient_K();
    if (part_maximum(model(), "rotor", rise_K) < 0.98 * rotor_final_K) rotor_s = time_s + 10.0;
    if (nose.dot(rise_K) < 0.98 * nose.dot(final_K)) nose_s = time_s + 10.0;
    if (inner.dot(rise_K) < 0.98 * inner.dot(final_K)) key_point_s = time_s + 10.0;
  }
  EXPECT_NEAR(rotor_s, 1170.0, 20.0);
  EXPECT_NEAR(nose_s, 1515.0, 20.0);
  EXPECT_NEAR(key_point_s, 2770.0, 30.0);
}

}  // namespace reference_spindle_test
}  // namespace spindle_twin::fem_offline

#include "rom/integrate/right_hand_side.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/rom/operating_values.hpp"
#include "tests/rom/shared_operator.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace right_hand_side_test {

TEST(BoundaryValues, a_single_number_that_is_none_makes_them_not_finite) {
  BoundaryValues good;
  const Eigen::VectorXd two = Eigen::Vector2d(1.0, 2.0);
  good.conductance_W_per_m2K = good.heat_W = good.environment_K = good.coolant_W_per_K = two;
  good.laws.flow_kg_per_s = good.laws.heat_factor = good.laws.conductance_factor = two;
  good.node_heat_W = good.capacity_factor = two;
  EXPECT_TRUE(all_finite(good));
  using Spoil = std::function<void(BoundaryValues&, double)>;
  const std::vector<Spoil> places = {
      [](BoundaryValues& v, double x) { v.conductance_W_per_m2K[1] = x; },
      [](BoundaryValues& v, double x) { v.heat_W[1] = x; },
      [](BoundaryValues& v, double x) { v.environment_K[0] = x; },
      [](BoundaryValues& v, double x) { v.coolant_W_per_K[1] = x; },
      [](BoundaryValues& v, double x) { v.laws.speed_rpm = x; },
      [](BoundaryValues& v, double x) { v.laws.load = x; },
      [](BoundaryValues& v, double x) { v.laws.current_A = x; },
      [](BoundaryValues& v, double x) { v.laws.power_W = x; },
      [](BoundaryValues& v, double x) { v.laws.flow_kg_per_s[0] = x; },
      [](BoundaryValues& v, double x) { v.laws.heat_factor[1] = x; },
      [](BoundaryValues& v, double x) { v.laws.conductance_factor[0] = x; },
      [](BoundaryValues& v, double x) { v.node_heat_W[1] = x; },
      [](BoundaryValues& v, double x) { v.capacity_factor[1] = x; },
  };
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (const double none : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
      BoundaryValues bad = good;
      places[i](bad, none);
      EXPECT_FALSE(all_finite(bad)) << "place " << i;
    }
  }
}

TEST(BoundaryValues, node_inputs_are_of_every_node_or_of_none_and_a_capacity_is_more_than_nothing) {
  Network network = make_synthetic_network({2, 2, 2, true}, 3);
  network.capacity_J_per_K = Eigen::VectorXd(network.capacity_J_per_K.rowwise().sum()).asDiagonal();
  const NetworkOperator nine(network);
  ASSERT_EQ(nine.nodes(), 9);
  for (const Eigen::Index size : {0, 1, 2, 8, 9, 10}) {
    BoundaryValues heats, factors;
    heats.node_heat_W = factors.capacity_factor = Eigen::VectorXd::Constant(size, 0.5);
    EXPECT_EQ(accepts(nine, heats), size == 0 || size == 9) << size;
    EXPECT_EQ(accepts(nine, factors), size == 0 || size == 9) << size;
  }
  BoundaryValues nothing;
  nothing.capacity_factor = Eigen::VectorXd::Ones(9);
  nothing.capacity_factor[8] = 0.0;
  EXPECT_FALSE(accepts(nine, nothing));
  nothing.capacity_factor[8] = 1e-9;
  EXPECT_TRUE(accepts(nine, nothing));
}

/// ∂f/∂x = −(K̃ − W Y Wᵀ) is exact where only heats follow the state; their conductances' slopes are not in Y.
TEST(RightHandSide, feedback_is_all_that_heats_and_coolant_add_to_the_jacobian) {
  Network all = make_network_with_laws();
  for (Conductance& conductance : all.boundaries.conductances) conductance.physics.reset();
  all.boundaries.sources[0].physics = all.boundaries.sources[3].physics;  // a law of the very first heat too
  for (const auto& [network, flow] : {std::pair{all, 1.0}, {all, -0.4}, {make_copper_node(), 1.0}}) {
    const auto shared = share(network);
    const Eigen::Index n = shared->nodes();
    BoundaryValues values = operating_values(network);
    values.coolant_W_per_K *= flow;
    Eigen::VectorXd x(n);
    shared->to_internal(Eigen::VectorXd::LinSpaced(n, 302.0, 325.0), x);
    for (const bool follow : {true, false}) {
      values.laws.follow = follow;
      RightHandSide rhs(shared);
      rhs.follow(values, x.data());
      ASSERT_EQ(rhs.following(), follow);
      Eigen::MatrixXd jacobian(n, n);
      rhs.linearise(x.data(), jacobian);
      const Eigen::MatrixXd symmetric = rhs.lower().selfadjointView<Eigen::Lower>();
      const Eigen::MatrixXd& columns = shared->feedback_columns();
      const Eigen::MatrixXd added = columns * rhs.feedback(x.data()) * columns.transpose();
      EXPECT_LT((symmetric - added - jacobian).cwiseAbs().maxCoeff(), 1e-12 * jacobian.cwiseAbs().maxCoeff());
      if (!follow && network.boundaries.circuits.empty()) continue;
      EXPECT_GT(added.cwiseAbs().maxCoeff(), 1e-6 * jacobian.cwiseAbs().maxCoeff());
    }
  }
}

TEST(RightHandSide, a_laws_conductance_is_that_of_before_until_it_has_moved_by_a_fiftieth) {
  const Network network = make_network_with_laws();
  const auto shared = share(network);
  const Eigen::Index n = shared->nodes();
  const BoundaryValues values = operating_values(network);
  int kept = 0, just_beyond = 0;
  for (const double warmer_K : {0.3, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0}) {
    RightHandSide rhs(shared);
    Eigen::VectorXd x(n);
    shared->to_internal(Eigen::VectorXd::Constant(n, 303.0), x);
    EXPECT_TRUE(rhs.follow(values, x.data())) << "the first";
    const Eigen::VectorXd before = rhs.conductance_W_per_m2K();
    const Eigen::VectorXd warm_K = Eigen::VectorXd::LinSpaced(n, 303.0, 303.0 + warmer_K);
    BoundaryValues now = values;
    shared->laws().at_temperatures(warm_K, now);
    shared->to_internal(warm_K, x);
    const bool changed = rhs.follow(values, x.data());
    const Eigen::VectorXd& taken = rhs.conductance_W_per_m2K();
    EXPECT_EQ(changed, taken != before) << warmer_K;
    for (const LawTerm& term : shared->laws().list()) {
      if (term.conductance < 0) continue;
      const double was = before[term.conductance], is = now.conductance_W_per_m2K[term.conductance];
      const double share_moved = std::abs(is - was) / std::abs(was);
      if (share_moved < 0.0199) {
        EXPECT_EQ(taken[term.conductance], was);
        kept += share_moved > 1e-6;
      } else if (share_moved > 0.0201) {
        EXPECT_NEAR(taken[term.conductance], is, 1e-9 * std::abs(is));
        just_beyond += share_moved < 0.039;
      }
    }
  }
  EXPECT_GT(kept, 3);
  EXPECT_GT(just_beyond, 1);
}

TEST(RightHandSide, says_whether_the_jacobian_changed) {
  Network network = make_network_with_circuit({2, 2, 2, true}, 3);
  network.capacity_J_per_K = Eigen::VectorXd(network.capacity_J_per_K.rowwise().sum()).asDiagonal();
  RightHandSide rhs(share(network));
  BoundaryValues values = operating_values(network);
  EXPECT_TRUE(rhs.hold(values)) << "the first";
  EXPECT_FALSE(rhs.hold(values));
  values.heat_W *= 2.0;
  values.environment_K.array() += 3.0;
  values.node_heat_W = Eigen::VectorXd::Ones(9);
  EXPECT_FALSE(rhs.hold(values)) << "heats and temperatures are not in it";
  values.coolant_W_per_K *= 0.5;
  EXPECT_TRUE(rhs.hold(values));
  EXPECT_FALSE(rhs.hold(values));
  values.capacity_factor = Eigen::VectorXd::Ones(9);
  EXPECT_TRUE(rhs.hold(values)) << "factors where there were none";
  EXPECT_FALSE(rhs.hold(values));
  values.capacity_factor[8] = 1.25;
  EXPECT_TRUE(rhs.hold(values));
  EXPECT_EQ(rhs.inverse_capacity()[8], 0.8);
  EXPECT_FALSE(rhs.hold(values));
  values.capacity_factor.resize(0);
  EXPECT_TRUE(rhs.hold(values));
  EXPECT_EQ(rhs.inverse_capacity().size(), 0);
  EXPECT_FALSE(rhs.hold(values));
  values.conductance_W_per_m2K[0] *= 1.1;
  EXPECT_TRUE(rhs.hold(values));
  EXPECT_FALSE(rhs.hold(values));
}

/// K̃ is that of its conductances, whichever were held before: few that differ are added to an earlier one.
TEST(RightHandSide, the_matrix_does_not_remember_which_conductances_were_before) {
  const Network network = make_synthetic_network({4, 3, 3, true}, 12);
  const auto shared = share(network);
  RightHandSide kept(shared);
  BoundaryValues values = operating_values(network);
  for (int k = 0; k < 12; ++k) {
    const Eigen::Index count = values.conductance_W_per_m2K.size();
    if (k % 4 == 3) {
      values.conductance_W_per_m2K *= 1.6;
    } else {
      values.conductance_W_per_m2K[k % count] *= k % 2 == 0 ? 3.0 : 0.0;
      values.conductance_W_per_m2K[(k + 2) % count] += 7.0;
    }
    kept.hold(values);
    RightHandSide fresh(shared);
    fresh.hold(values);
    const Eigen::MatrixXd whole = fresh.lower().triangularView<Eigen::Lower>();
    const Eigen::MatrixXd is = kept.lower().triangularView<Eigen::Lower>();
    EXPECT_LT((is - whole).cwiseAbs().maxCoeff(), 1e-12 * whole.cwiseAbs().maxCoeff()) << k;
  }
}

TEST(RightHandSide, the_matrix_comes_back_to_the_bit_with_the_conductances) {
  const Network network = make_synthetic_network({4, 3, 3, true}, 12);
  RightHandSide rhs(share(network));
  BoundaryValues values = operating_values(network);
  rhs.hold(values);
  const Eigen::MatrixXd before = rhs.lower();
  values.conductance_W_per_m2K[1] *= 1.5;
  rhs.hold(values);
  EXPECT_NE(rhs.lower(), before);
  rhs.hold(operating_values(network));
  EXPECT_EQ(rhs.lower(), before);
}

TEST(NetworkOperator, one_kelvin_everywhere_is_the_root_of_all_capacity) {
  const Network network = make_synthetic_network({3, 2, 2, true}, 2);
  const auto shared = share(network);
  const Eigen::Index n = shared->nodes();
  Eigen::VectorXd x(n), back_K(n);
  shared->to_internal(Eigen::VectorXd::Constant(n, shared->reference_K() + 1.0), x);
  EXPECT_NEAR(x.squaredNorm(), network.capacity_J_per_K.sum(), 1e-9 * network.capacity_J_per_K.sum());
  EXPECT_NEAR(x.norm(), shared->internal_per_kelvin() * std::sqrt(static_cast<double>(n)), 1e-9 * x.norm());
  shared->to_temperatures(x, back_K);
  EXPECT_LT((back_K.array() - shared->reference_K() - 1.0).abs().maxCoeff(), 1e-10);
}

TEST(NetworkOperator, a_conductance_counts_in_proportion_also_where_it_is_one) {
  const Network network = make_single_node();
  BoundaryValues values = operating_values(network);
  RightHandSide rhs(share(network));
  for (const double film_W_per_m2K : {0.0, 0.5, 1.0, 2.0, 50.0}) {
    values.conductance_W_per_m2K[0] = film_W_per_m2K;
    rhs.hold(values);
    EXPECT_NEAR(rhs.lower()(0, 0), film_W_per_m2K * 0.5 / 1000.0, 1e-15) << film_W_per_m2K;
  }
}

TEST(NetworkOperator, a_factor_that_does_not_fit_is_refused) {
  using Change = std::function<void(Network&)>;
  const std::vector<Change> wrong = {
      [](Network& n) { n.capacity_J_per_K(3, 3) = -1.0; },
      [](Network& n) { n.factors_m[0].conservativeResize(12, Eigen::NoChange); },
      [](Network& n) { n.factors_m.back().conservativeResize(14, Eigen::NoChange); },
      [](Network& n) { n.boundaries.conductances.back().environment = 2; },
  };
  const Network good = make_synthetic_network({3, 2, 2, true}, 2);
  ASSERT_EQ(good.capacity_J_per_K.rows(), 13);
  ASSERT_EQ(good.boundaries.environments.size(), 2U);
  EXPECT_NO_THROW(NetworkOperator{good});
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    Network network = good;
    wrong[i](network);
    EXPECT_THROW(NetworkOperator{network}, std::invalid_argument) << i;
  }
}

}  // namespace right_hand_side_test
}  // namespace spindle_twin::rom::tests

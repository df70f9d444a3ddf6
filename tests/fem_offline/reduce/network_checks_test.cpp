#include "fem_offline/reduce/network_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/choose_size.hpp"
#include "fem_offline/reduce/history_errors.hpp"
#include "fem_offline/reduce/mesh_error.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "grid_model.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_network_checks_test {

ReduceOptions checked_options(int nodes) {
  ReduceOptions options;
  options.nodes = nodes;
  options.full_sets = 30;
  options.full_histories = 30;
  options.rich_sets = 30;
  options.rich_states = 160;
  return options;
}

rom::Network grid_network(int nodes) { return reduce_model(make_grid_model(), checked_options(nodes)); }

rom::Network jacket_network() {
  const FeModel model = build_fe_model(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/jacket_circuit.toml");
  return reduce_model(model.affine(), checked_options(30));
}

std::vector<DriveCase> drives(const rom::Network& network, bool drift) {
  CaseOptions options;
  options.drift = drift;
  return {random_case(network.boundaries, 4, 0, options)};
}

TEST(NetworkChecks, a_reduced_network_keeps_its_laws) {
  for (const bool drift : {false, true}) {
    const rom::Network network = grid_network(40);
    const NetworkChecks checks = check_laws(network, drives(network, drift));
    EXPECT_TRUE(checks.passed());
    EXPECT_LT(checks.heat_balance, 1e-9);
    EXPECT_LT(checks.row_sum, 1e-12);
  }
}

TEST(NetworkChecks, heat_balance_closes_with_a_coolant_circuit) {
  const rom::Network network = jacket_network();
  EXPECT_LT(heat_unbalanced(network, drives(network, false).front()), 1e-9);
}

TEST(NetworkChecks, see_conduction_that_loses_heat) {
  rom::Network network = grid_network(40);
  network.conduction_W_per_K(3, 3) += 1e-4 * network.conduction_W_per_K.cwiseAbs().maxCoeff();
  const NetworkChecks checks = check_laws(network, drives(network, false));
  EXPECT_FALSE(checks.passed());
  EXPECT_GT(checks.row_sum, 1e-6);
  EXPECT_GT(checks.heat_balance, 1e-7);
}

TEST(NetworkChecks, see_a_source_that_makes_heat_of_its_own) {
  rom::Network network = grid_network(40);
  network.source_distribution.col(3) *= 1.001;
  const NetworkChecks checks = check_laws(network, drives(network, false));
  EXPECT_GT(checks.source_sum, 1e-4);
  EXPECT_GT(checks.heat_balance, 1e-5);
}

TEST(NetworkChecks, see_a_capacity_that_is_not_positive_definite) {
  rom::Network network = grid_network(20);
  network.capacity_J_per_K(5, 5) = -1.0;
  EXPECT_FALSE(check_laws(network, {}).passed());
}

TEST(SizeChoice, takes_the_smallest_size_that_keeps_the_tolerance) {
  const AffineModel model = make_grid_model();
  const ReduceOptions options = checked_options(2);
  const Reduction reduction(model, options);
  const auto nodes_for = [&](const Tolerance& tolerance) {
    const SizeChoice choice = choose_size(model, reduction, {tolerance, 2}, options);
    EXPECT_TRUE(choice.reached);
    for (const TriedSize& tried : choice.tried) {
      const bool kept = tried.reached.key_points_K <= share_of_tolerance * tolerance.key_points_K &&
                        tried.reached.deformations_um <= share_of_tolerance * tolerance.deformations_um &&
                        tried.reached.part_max_K <= share_of_tolerance * tolerance.part_max_K;
      EXPECT_EQ(kept, tried.nodes >= static_cast<int>(choice.network.nodes.size())) << tried.nodes;
    }
    return choice.network.nodes.size();
  };
  EXPECT_LT(nodes_for({3.0, 3.0, 12.0}), nodes_for({0.2, 0.2, 0.8}));
}

TEST(SizeChoice, judges_a_size_by_what_a_tenth_of_all_histories_may_exceed) {
  const AffineModel model = make_grid_model();
  const ReduceOptions options = checked_options(2);
  const Reduction reduction(model, options);
  const SizeChoice choice = choose_size(model, reduction, {{3.0, 3.0, 12.0}, size_choice_histories}, options);
  const TriedSize& tried = choice.tried.front();
  const rom::Network network = reduction.network(tried.nodes);
  // Nodes are chosen here, in the search none: the temperatures must not depend on them.
  const Eigen::MatrixXd errors =
      history_errors(model, {dense_model_of(network), output_rows_of(network)},
                     run_fe_histories(model, options, size_choice_histories), options.threads);
  const OutputLayout layout = output_layout(model);
  const auto third_largest = [&](Eigen::Index first, Eigen::Index count) {
    Eigen::VectorXd largest = errors.middleRows(first, count).colwise().maxCoeff();
    std::sort(largest.begin(), largest.end());
    return largest[size_choice_histories - 3];
  };
  EXPECT_NEAR(tried.reached.key_points_K, third_largest(0, layout.key_points), 1e-8);
  EXPECT_NEAR(tried.reached.part_max_K, third_largest(layout.maxima_at(), layout.parts), 1e-8);
}

TEST(SizeChoice, says_when_no_size_is_enough) {
  const AffineModel model = make_grid_model();
  ReduceOptions options = checked_options(2);
  options.rich_states = 40;
  options.rich_states_per_body = 0;
  const Reduction reduction(model, options);
  const SizeChoice choice = choose_size(model, reduction, {{1e-9, 1e-9, 1e-9}, 1}, options);
  EXPECT_FALSE(choice.reached);
  EXPECT_EQ(choice.network.nodes.size(), 40u);
  EXPECT_FALSE(choice.larger_possible);
}

TEST(SizeChoice, names_what_the_network_that_comes_nearest_misses) {
  const AffineModel model = make_grid_model();
  ReduceOptions options = checked_options(2);
  options.rich_states = 40;
  options.rich_states_per_body = 0;
  const Reduction reduction(model, options);
  const double never = 1e9, always = 1e-9;
  const SizeChoice choice = choose_size(model, reduction, {{never, never, always}, 1}, options);
  ASSERT_EQ(choice.missed.size(), model.parts.size());
  for (std::size_t i = 0; i < choice.missed.size(); ++i) {
    EXPECT_EQ(choice.missed[i].kind, MissedOutput::Kind::part_maximum);
    EXPECT_EQ(choice.missed[i].wanted, share_of_tolerance * always);
    EXPECT_LE(choice.missed[i].error, choice.missed[i > 0 ? i - 1 : 0].error);
  }
  double smallest_K = never;
  for (const TriedSize& tried : choice.tried) smallest_K = std::min(smallest_K, tried.reached.part_max_K);
  EXPECT_EQ(choice.missed.front().error, smallest_K);
  EXPECT_TRUE(choose_size(model, reduction, {{never, never, never}, 1}, options).missed.empty());
}

TEST(MeshError, falls_with_the_element_size_in_steady_state_and_over_the_warm_up) {
  const auto errors_K = [](double element_size_m) {
    Spindle spindle = read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/shaft_in_sleeve.toml");
    spindle.mesh.element_size_m = element_size_m;
    const FeModel model(spindle, build_section(spindle));
    rom::Certificate certificate;
    certificate.key_points_K.resize(model.affine().key_points.size());
    certificate.part_means_K.resize(model.affine().parts.size());
    certificate.part_maxima_K.resize(model.affine().parts.size());
    certificate.deformations_m.resize(model.affine().deformations.size());
    certificate.contact_pressures_Pa.resize(model.affine().contact_pressures.size());
    measure_mesh_error(model, {}, certificate);
    const Eigen::VectorXd steady = steady_mesh_error(model);
    const Eigen::Index at = output_layout(model.affine()).maxima_at();
    return std::pair{certificate.part_maxima_K.front().mesh, std::abs(steady[at])};
  };
  const auto [coarse_K, coarse_steady_K] = errors_K(8e-3);
  const auto [fine_K, fine_steady_K] = errors_K(4e-3);
  EXPECT_GT(coarse_K, 0.0);
  EXPECT_LT(fine_K, coarse_K);
  EXPECT_LT(fine_steady_K, coarse_steady_K);
  EXPECT_GE(coarse_K, coarse_steady_K);  // the steady end is one of the instants
}

}  // namespace reduce_network_checks_test
}  // namespace spindle_twin::fem_offline

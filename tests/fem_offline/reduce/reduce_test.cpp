#include "fem_offline/reduce/reduce.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <set>

#include "grid_model.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_reduce_test {

ReduceOptions small_options(int nodes) {
  ReduceOptions options;
  options.nodes = nodes;
  options.seed = 7;
  options.threads = 2;
  options.full_sets = 40;
  options.full_histories = 40;
  options.rich_states = 220;
  options.rich_sets = 60;
  return options;
}

const AffineModel& grid() {
  static const AffineModel model = make_grid_model();
  return model;
}

const rom::Network& network_60() {
  static const rom::Network network = reduce_model(grid(), small_options(60));
  return network;
}

rom::BoundaryValues random_values(std::uint32_t index) {
  const rom::Boundaries& boundaries = grid().boundaries;
  RandomStream random(99, StreamPurpose::verification, index);
  rom::CorrectionFactors factors = rom::no_correction(boundaries);
  factors.conductance = random_conductance_factors(boundaries, {}, false, random);
  rom::OperatingState state = boundaries.operating;
  state.speed_rpm = random.uniform(0.0, 24000.0);
  state.environment_K << random.uniform(285.0, 310.0), random.uniform(285.0, 310.0);
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, state, factors, values);
  return values;
}

Eigen::VectorXd full_steady(const AffineModel& model, const rom::BoundaryValues& values) {
  SparseMatrix conduction = model.conduction_W_per_K;
  Eigen::VectorXd drive = model.source_distribution * values.heat_W;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(conduction.rows());
  for (std::size_t j = 0; j < model.conductance_terms_m2.size(); ++j) {
    const double g = values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)];
    conduction += g * model.conductance_terms_m2[j];
    const int environment = model.boundaries.conductances[j].environment;
    if (environment >= 0) drive += g * values.environment_K[environment] * (model.conductance_terms_m2[j] * ones);
  }
  return Eigen::SimplicialLDLT<SparseMatrix>(conduction).solve(drive);
}

Eigen::VectorXd network_steady(const rom::Network& network, const rom::BoundaryValues& values) {
  Eigen::MatrixXd conduction = network.conduction_W_per_K;
  Eigen::VectorXd drive = network.source_distribution * values.heat_W;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const double g = values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)];
    const Eigen::MatrixXd& factor = network.factors_m[j];
    conduction += g * factor * factor.transpose();
    const int environment = network.boundaries.conductances[j].environment;
    if (environment >= 0) drive += g * values.environment_K[environment] * factor * factor.colwise().sum().transpose();
  }
  return conduction.llt().solve(drive);
}

/// Worst error over nodes (against the FE temperature at the node's unknown) and key points, five random operating
/// points.
double steady_error_K(const rom::Network& network) {
  double worst_K = 0.0;
  for (std::uint32_t index = 0; index < 5; ++index) {
    const rom::BoundaryValues values = random_values(index);
    const Eigen::VectorXd full_K = full_steady(grid(), values);
    const Eigen::VectorXd nodes_K = network_steady(network, values);
    for (std::size_t i = 0; i < grid().key_points.size(); ++i) {
      worst_K =
          std::max(worst_K, std::abs(network.key_points[i].row.dot(nodes_K) - grid().key_points[i].row.dot(full_K)));
    }
    for (std::size_t i = 0; i < network.nodes.size(); ++i) {
      for (std::size_t u = 0; u < grid().places.size(); ++u) {
        const DofPlace& place = grid().places[u];
        const std::string part = place.part < 0 ? "" : grid().parts[static_cast<std::size_t>(place.part)].name;
        if (part != network.nodes[i].part || place.r_m != network.nodes[i].r_m || place.z_m != network.nodes[i].z_m)
          continue;
        worst_K =
            std::max(worst_K, std::abs(full_K[static_cast<Eigen::Index>(u)] - nodes_K[static_cast<Eigen::Index>(i)]));
      }
    }
  }
  return worst_K;
}

TEST(Network, conduction_and_exchange_conserve_heat_to_rounding) {
  const rom::Network& network = network_60();
  const double size = network.conduction_W_per_K.cwiseAbs().maxCoeff();
  EXPECT_LE(network.conduction_W_per_K.rowwise().sum().cwiseAbs().maxCoeff(), 1e-12 * size);
  EXPECT_LE(network.conduction_W_per_K.colwise().sum().cwiseAbs().maxCoeff(), 1e-12 * size);
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const Eigen::MatrixXd& factor = network.factors_m[j];
    ASSERT_GT(factor.cols(), 0);
    if (network.boundaries.conductances[j].environment >= 0) continue;
    EXPECT_LE(factor.colwise().sum().cwiseAbs().maxCoeff(), 1e-12 * factor.cwiseAbs().maxCoeff())
        << network.boundaries.conductances[j].name;
  }
}

TEST(Network, sources_give_all_their_heat_to_the_nodes) {
  const Eigen::RowVectorXd sums = network_60().source_distribution.colwise().sum();
  EXPECT_LE((sums.array() - 1.0).abs().maxCoeff(), 1e-14);
}

TEST(Network, films_keep_their_area_and_bodies_their_capacity) {
  const rom::Network& network = network_60();
  EXPECT_NEAR(network.capacity_J_per_K.sum() / grid().capacity_J_per_K.sum(), 1.0, 1e-12);
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const rom::Conductance& item = network.boundaries.conductances[j];
    if (item.environment < 0) continue;
    EXPECT_NEAR(network.factors_m[j].colwise().sum().squaredNorm() / item.area_m2, 1.0, 1e-11) << item.name;
  }
}

TEST(Network, matrices_are_symmetric_positive_definite) {
  const rom::Network& network = network_60();
  EXPECT_EQ(network.capacity_J_per_K, network.capacity_J_per_K.transpose());
  EXPECT_EQ(network.conduction_W_per_K, network.conduction_W_per_K.transpose());
  EXPECT_EQ(network.capacity_J_per_K.llt().info(), Eigen::Success);
  Eigen::MatrixXd loss = network.conduction_W_per_K;
  for (const Eigen::MatrixXd& factor : network.factors_m) loss += 1e-3 * factor * factor.transpose();
  EXPECT_EQ(loss.llt().info(), Eigen::Success);
}

TEST(Network, uniform_surroundings_make_a_uniform_field) {
  rom::BoundaryValues values = random_values(3);
  values.heat_W.setZero();
  values.environment_K.setConstant(305.0);
  const rom::Network& network = network_60();
  const Eigen::VectorXd nodes_K = network_steady(network, values);
  EXPECT_LE((nodes_K.array() - 305.0).abs().maxCoeff(), 1e-8);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(nodes_K.size());
  for (const rom::KeyPoint& point : network.key_points) EXPECT_NEAR(point.row.dot(ones), 1.0, 1e-12);
  for (const rom::PartOutput& part : network.parts) {
    EXPECT_NEAR(part.mean_row.dot(ones), 1.0, 1e-12);
    EXPECT_LE(((part.candidate_rows * ones).array() - 1.0).abs().maxCoeff(), 1e-12);
    EXPECT_LE(part.candidate_rows.rows(), 400);
  }
  EXPECT_NEAR(network.deformations[0].row_m_per_K.sum() / grid().deformations[0].row_m_per_K.sum(), 1.0, 1e-12);
}

TEST(Network, steady_heat_in_equals_heat_out) {
  const rom::BoundaryValues values = random_values(4);
  const rom::Network& network = network_60();
  const Eigen::VectorXd nodes_K = network_steady(network, values);
  double out_W = 0.0;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const int environment = network.boundaries.conductances[j].environment;
    if (environment < 0) continue;
    const Eigen::MatrixXd& factor = network.factors_m[j];
    const Eigen::VectorXd rise_K = nodes_K.array() - values.environment_K[environment];
    out_W += values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] *
             factor.colwise().sum().dot(factor.transpose() * rise_K);
  }
  EXPECT_NEAR(out_W / values.heat_W.sum(), 1.0, 1e-8);
}

TEST(Network, steady_error_falls_with_nodes_towards_the_full_model) {
  const double at_20_K = steady_error_K(reduce_model(grid(), small_options(20)));
  const double at_60_K = steady_error_K(network_60());
  const double at_150_K = steady_error_K(reduce_model(grid(), small_options(150)));
  EXPECT_LT(at_60_K, 0.2 * at_20_K) << at_20_K;
  EXPECT_LT(at_150_K, 0.1 * at_60_K) << at_60_K;
  EXPECT_LT(at_150_K, 3e-3);
}

TEST(Network, nodes_are_distinct_named_points_in_good_coordinates) {
  ReduceReport report;
  const rom::Network network = reduce_model(grid(), small_options(60), {}, &report);
  EXPECT_GT(report.condition, 1.0);
  EXPECT_LT(report.condition, 100.0);
  std::set<std::string> names;
  for (const rom::Node& node : network.nodes) names.insert(node.name);
  EXPECT_EQ(names.size(), network.nodes.size());
  EXPECT_EQ(network.nodes.size(), 60u);
}

TEST(Network, same_seed_gives_the_same_bits_on_any_number_of_threads) {
  ReduceOptions options = small_options(60);
  options.threads = 3;
  const rom::Network again = reduce_model(grid(), options);
  const rom::Network& network = network_60();
  EXPECT_EQ(network.capacity_J_per_K, again.capacity_J_per_K);
  EXPECT_EQ(network.conduction_W_per_K, again.conduction_W_per_K);
  EXPECT_EQ(network.source_distribution, again.source_distribution);
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) EXPECT_EQ(network.factors_m[j], again.factors_m[j]);
  for (std::size_t p = 0; p < network.parts.size(); ++p) {
    EXPECT_EQ(network.parts[p].candidate_rows, again.parts[p].candidate_rows);
  }
  options.seed = 8;
  EXPECT_NE(network.capacity_J_per_K, reduce_model(grid(), options).capacity_J_per_K);
}

// What the search for a size relies on: it projects the FE model once for several sizes.
TEST(Reduction, the_model_of_fewer_nodes_is_the_first_part_of_a_larger_one) {
  const Reduction reduction(grid(), small_options(60));
  const DenseModel larger = reduction.dense_model(60), smaller = reduction.dense_model(40);
  const DenseModel first = first_states(larger, 40);
  const double tolerance = 1e-12 * smaller.conduction.norm();
  EXPECT_LT((first.conduction - smaller.conduction).norm(), tolerance);
  EXPECT_LT((first.capacity - smaller.capacity).norm(), 1e-12 * smaller.capacity.norm());
  EXPECT_LT((first.source_distribution - smaller.source_distribution).norm(), 1e-12);
  EXPECT_EQ(reduction.part_extremes(first), reduction.part_extremes(smaller));
}

TEST(Network, refuses_more_nodes_than_unknowns) {
  EXPECT_THROW(reduce_model(grid(), small_options(5000)), std::invalid_argument);
  EXPECT_THROW(reduce_model(grid(), small_options(1)), std::invalid_argument);
}

}  // namespace reduce_reduce_test
}  // namespace spindle_twin::fem_offline

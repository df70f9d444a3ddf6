#include "fem_offline/reduce/output_rows.hpp"

#include <gtest/gtest.h>

#include "fem_offline/reduce/reduce.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "grid_model.hpp"
#include "rom/integrate/outputs.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_output_rows_test {

TEST(OutputRows, of_a_network_give_for_many_fields_at_once_what_the_runtime_gives_for_each) {
  const AffineModel model = make_grid_model();
  ReduceOptions options;
  options.nodes = 12;
  options.full_sets = options.full_histories = options.rich_sets = 10;
  options.rich_states = 40;
  const rom::Network network = reduce_model(model, options);
  const double reference_K = network.boundaries.reference_temperature_K;
  std::srand(3);
  const Eigen::MatrixXd rises_K = 20.0 * Eigen::MatrixXd::Random(network.capacity_J_per_K.rows(), 7);
  const Eigen::MatrixXd outputs = outputs_of(output_rows_of(network), rises_K);
  rom::NetworkOutputs runtime = rom::make_network_outputs(network);
  for (Eigen::Index i = 0; i < rises_K.cols(); ++i) {
    rom::evaluate_outputs(network, rises_K.col(i).array() + reference_K, runtime);
    const Eigen::VectorXd expected = network_outputs(runtime);
    EXPECT_LT((outputs.col(i) - expected).cwiseAbs().maxCoeff(), 1e-10) << i;
  }
}

TEST(OutputRows, of_a_basis_that_leaves_nothing_out_give_what_the_fe_model_gives) {
  const AffineModel model = make_grid_model();
  const Eigen::Index unknowns = model.capacity_J_per_K.rows();
  PartExtremes all_points;
  for (const FePart& part : model.parts) {
    all_points.emplace_back();
    for (std::size_t i = 0; i < part.dofs.size(); ++i) all_points.back().push_back(static_cast<int>(i));
  }
  const OutputRows rows = project_output_rows(model, Eigen::MatrixXd::Identity(unknowns, unknowns), all_points);
  std::srand(4);
  const Eigen::VectorXd rise_K = 20.0 * Eigen::VectorXd::Random(unknowns);
  const Eigen::VectorXd expected = fe_outputs(model, rise_K.array() + model.boundaries.reference_temperature_K);
  EXPECT_LT((outputs_of(rows, rise_K) - expected).cwiseAbs().maxCoeff(), 1e-10);
}

}  // namespace reduce_output_rows_test
}  // namespace spindle_twin::fem_offline

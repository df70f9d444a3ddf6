#include <cstdio>
#include <stdexcept>

#include "correction/estimator/estimator_correction.hpp"
#include "fem_offline/reduce/reduce.hpp"
#include "tests/bench/rows.hpp"

namespace spindle_twin::bench {

void print_estimator_rows() {
  constexpr double element_size_mm = 6.0, period_s = 10.0;
  constexpr int updates = 50, repeats = 3;
  fem_offline::ReduceOptions reduce;
  reduce.nodes = 200;
  reduce.full_sets = 20;
  reduce.rich_states = 300;
  reduce.rich_sets = 60;
  const rom::Network network = fem_offline::reduce_model(reference_model(element_size_mm, false).affine(), reduce);
  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  correction::EstimatorCorrection estimator(network, {});
  const auto sensors = static_cast<Eigen::Index>(estimator.sensors().size());
  const auto valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(sensors, true).eval();
  const double reference_K = network.boundaries.reference_temperature_K;
  const Eigen::VectorXd nodes_K = Eigen::VectorXd::Constant(nodes, reference_K + 2.0);
  const Eigen::VectorXd measured_K = Eigen::VectorXd::Constant(sensors, reference_K + 2.02);
  estimator.reset(0.0, nodes_K, network.boundaries.operating);
  double time_s = 0.0;
  const auto step = [&] {
    estimator.step({time_s, measured_K, valid, nodes_K, network.boundaries.operating}, period_s);
    time_s += period_s;
  };
  step();  // opens the first period
  const double update_s = thread_seconds(repeats, [&] {
    for (int i = 0; i < updates; ++i) step();
  });
  if (estimator.updates() != repeats * updates || estimator.failures() != 0) {
    throw std::runtime_error("not every step of the bench was an update");
  }
  const Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(nodes, nodes) * 0.5;
  Eigen::VectorXd vector = Eigen::VectorXd::Ones(nodes), product(nodes);
  const double products_s = thread_seconds(repeats, [&] {
    for (int i = 0; i < 400 * updates; ++i) {
      product.noalias() = dense * vector;
      vector.swap(product);
    }
  });
  std::printf("estimator: %ld nodes, %ld parameters, %ld sensors\n", static_cast<long>(nodes),
              static_cast<long>(estimator.parameters().count()), static_cast<long>(sensors));
  print_row("one update, all of it in one cycle", 1e3 * update_s / updates, "ms");
  print_row("one update / bare matrix-vector products of its size", 400.0 * update_s / products_s, "x", "<= 400");
}

}  // namespace spindle_twin::bench

#include <stdexcept>
#include <string>

#include "correction/estimator/estimator_correction.hpp"
#include "tests/bench/rows.hpp"

namespace spindle_twin::bench {

void print_estimator_rows(const RowPrinter& printer) {
  constexpr double period_s = 10.0;
  constexpr int updates = 50, repeats = 3;
  const rom::Network network = network_of_200_nodes();
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
  const double all_s = thread_seconds(repeats, [&] {
    for (int i = 0; i < updates; ++i) step();
  });
  if (estimator.updates() != repeats * updates || estimator.failures() != 0) {
    throw std::runtime_error("not every step of the bench was an update");
  }
  printer.print(
      {.group = "Daemon",
       .name = "update of the estimator, " + std::to_string(nodes) + " nodes, " +
               std::to_string(estimator.parameters().count()) + " parameters",
       .ours_s = all_s / updates,
       .other_name = "one bare matrix-vector product",
       .other_s = bare_product_seconds(nodes),
       .means = "All that ten seconds need: sensitivities carried on, readings taken in, state corrected, deviations.",
       .goal = 400.0});
}

}  // namespace spindle_twin::bench

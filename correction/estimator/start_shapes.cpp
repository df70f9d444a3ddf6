#include "correction/estimator/start_shapes.hpp"

#include <Eigen/Cholesky>
#include <utility>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double stopped_s = 900.0;
constexpr int stopped_steps = 15;

void add(std::vector<StartShape>& shapes, const char* name, Eigen::VectorXd rise_K) {
  const double largest = rise_K.lpNorm<Eigen::Infinity>();
  if (!(largest > 0.0) || !rise_K.allFinite()) return;
  rise_K /= largest;
  shapes.push_back({name, std::move(rise_K)});
}

/// The steady rises that the nominal heats alone drive, and what is left of them when they have stopped. None without
/// heats, or without a way out for them.
void add_running(const rom::Network& network, const rom::NetworkOperator& coordinates,
                 std::vector<StartShape>& shapes) {
  const Eigen::Index n = coordinates.nodes();
  rom::BoundaryValues values = make_boundary_values(network.boundaries);
  evaluate_boundaries(network.boundaries, network.boundaries.operating, no_correction(network.boundaries), values);
  // Rises above surroundings at the reference temperature, so that nothing but the heats drives them.
  values.environment_K.setConstant(coordinates.reference_K());
  Eigen::VectorXd packed = coordinates.make_packed();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
  coordinates.assemble(values.conductance_W_per_m2K, packed, lower);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n), rise_K = x;
  coordinates.drive(values, x);
  const Eigen::LLT<Eigen::MatrixXd> steady(lower.selfadjointView<Eigen::Lower>().toDenseMatrix());
  if (steady.info() != Eigen::Success) return;
  x = steady.solve(x).eval();
  const auto in_kelvin = [&] {
    coordinates.to_temperatures(x, rise_K);
    rise_K.array() -= coordinates.reference_K();
    return rise_K;
  };
  add(shapes, "running", in_kelvin());
  Eigen::MatrixXd step = (stopped_s / stopped_steps) * lower.selfadjointView<Eigen::Lower>().toDenseMatrix();
  step.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> cooling(step);
  for (int k = 0; k < stopped_steps; ++k) x = cooling.solve(x).eval();
  add(shapes, "stopped", in_kelvin());
}

}  // namespace

std::vector<StartShape> start_shapes(const rom::Network& network, const rom::NetworkOperator& coordinates,
                                     const std::vector<ThermalGroup>& groups) {
  std::vector<StartShape> shapes;
  add(shapes, "uniform", Eigen::VectorXd::Ones(coordinates.nodes()));
  add_running(network, coordinates, shapes);
  if (groups.size() < 2) return shapes;
  for (const ThermalGroup& group : groups) shapes.push_back({group.name, group.indicator});
  return shapes;
}

}  // namespace spindle_twin::correction

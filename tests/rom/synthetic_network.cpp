#include "tests/rom/synthetic_network.hpp"

#include <cmath>
#include <random>

namespace spindle_twin::rom::tests {
namespace {

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

double log_uniform(std::mt19937_64& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}

void add_exchange(Eigen::MatrixXd& matrix, Eigen::Index a, Eigen::Index b, double value) {
  matrix(a, a) += value;
  matrix(b, b) += value;
  matrix(a, b) -= value;
  matrix(b, a) -= value;
}

/// Consistent capacity of a two-node element: two thirds on the nodes, one third between them.
void add_capacity(Eigen::MatrixXd& matrix, Eigen::Index a, Eigen::Index b, double value) {
  matrix(a, a) += value / 3.0;
  matrix(b, b) += value / 3.0;
  matrix(a, b) += value / 6.0;
  matrix(b, a) += value / 6.0;
}

void add_conductance(Network& network, const std::string& name, ConductanceKind kind, double nominal, int environment,
                     const Eigen::MatrixXd& factor) {
  Conductance conductance;
  conductance.name = name;
  conductance.kind = kind;
  conductance.nominal_W_per_m2K = nominal;
  conductance.area_m2 = factor.squaredNorm() / (environment < 0 ? 2.0 : 1.0);
  conductance.environment = environment;
  if (kind != ConductanceKind::contact) conductance.law = {0.2, {{0.8, 0.7}}, 0.0, false};
  network.boundaries.conductances.push_back(conductance);
  network.factors_m.push_back(factor);
}

void add_source(Network& network, const std::string& name, double nominal_W, const Eigen::VectorXd& distribution) {
  network.boundaries.sources.push_back({name, nominal_W, {0.0, {{0.5, 1.0}, {0.3, 1.5}}, 0.2, true}});
  network.source_distribution.conservativeResize(distribution.size(), network.source_distribution.cols() + 1);
  network.source_distribution.rightCols(1) = distribution;
}

}  // namespace

Network make_synthetic_network(const SyntheticShape& shape, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const Eigen::Index plate = static_cast<Eigen::Index>(shape.columns) * shape.rows;
  const Eigen::Index n = shape.bodies * plate + 1;
  const Eigen::Index air = n - 1;
  const auto at = [&](int body, int column, int row) -> Eigen::Index {
    return body * plate + column * shape.rows + row;
  };

  Network network;
  network.spindle = "synthetic";
  network.description_hash = std::string(64, 'a');
  network.capacity_J_per_K = network.conduction_W_per_K = Eigen::MatrixXd::Zero(n, n);
  network.source_distribution.resize(n, 0);
  network.boundaries.reference_speed_rpm = 6000.0;
  network.boundaries.reference_temperature_K = 300.15;
  network.boundaries.operating.speed_rpm = 6000.0;
  network.boundaries.operating.load = 1.0;

  for (int body = 0; body < shape.bodies; ++body) {
    PartOutput part{"plate " + std::to_string(body), Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(plate, n)};
    for (int column = 0; column < shape.columns; ++column) {
      for (int row = 0; row < shape.rows; ++row) {
        const Eigen::Index here = at(body, column, row);
        network.nodes.push_back({part.name + " " + std::to_string(column) + "," + std::to_string(row), part.name,
                                 0.01 * row, 0.01 * (body * shape.columns + column)});
        part.mean_row[here] = 1.0 / static_cast<double>(plate);
        part.candidate_rows(here - body * plate, here) = 1.0;
        network.capacity_J_per_K(here, here) += log_uniform(random, 20.0, 600.0);
        for (const Eigen::Index next : {column + 1 < shape.columns ? at(body, column + 1, row) : here,
                                        row + 1 < shape.rows ? at(body, column, row + 1) : here}) {
          if (next == here) continue;
          add_exchange(network.conduction_W_per_K, here, next, log_uniform(random, 2.0, 80.0));
          add_capacity(network.capacity_J_per_K, here, next, log_uniform(random, 20.0, 600.0));
        }
      }
    }
    network.parts.push_back(part);
  }
  network.nodes.push_back({"air", "", 0.0, 0.0});
  network.capacity_J_per_K(air, air) = 0.3;

  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(n, shape.rows);
  for (int body = 0; body + 1 < shape.bodies; ++body) {
    Eigen::MatrixXd factor = none;
    for (int row = 0; row < shape.rows; ++row) {
      const double root_area = std::sqrt(uniform(random, 1e-3, 4e-3));
      factor(at(body, shape.columns - 1, row), row) = root_area;
      factor(at(body + 1, 0, row), row) = -root_area;
    }
    add_conductance(network, "contact " + std::to_string(body), ConductanceKind::contact,
                    log_uniform(random, 500.0, 9000.0), -1, factor);
    network.boundaries.conductances.back().part_a = body;
    network.boundaries.conductances.back().part_b = body + 1;
    network.boundaries.conductances.back().fit = JointFit{4e6, 2.5e5, 2.2e5};
  }
  Eigen::MatrixXd in_air = none;
  for (int row = 0; row < shape.rows; ++row) {
    const double root_area = std::sqrt(uniform(random, 1e-3, 4e-3));
    in_air(at(shape.bodies / 2, 0, row), row) = root_area;
    in_air(air, row) = -root_area;
  }
  add_conductance(network, "cavity", ConductanceKind::air_film, 22.0, -1, in_air);

  if (shape.environments) {
    network.boundaries.environments = {{"coolant", EnvironmentKind::coolant}, {"ambient", EnvironmentKind::ambient}};
    network.boundaries.operating.environment_K = Eigen::Vector2d(300.15, 300.15);
    Eigen::MatrixXd coolant = none, ambient = none;
    for (int row = 0; row < shape.rows; ++row) {
      coolant(at(0, 0, row), row) = std::sqrt(uniform(random, 2e-3, 2e-2));
      ambient(at(shape.bodies - 1, shape.columns - 1, row), row) = std::sqrt(uniform(random, 2e-3, 2e-2));
    }
    add_conductance(network, "coolant film", ConductanceKind::environment_film, 548.0, 0, coolant);
    add_conductance(network, "ambient film", ConductanceKind::environment_film, 45.0, 1, ambient);
  }

  add_source(network, "bearing", 60.0, Eigen::VectorXd::Unit(n, at(0, shape.columns / 2, shape.rows / 2)));
  Eigen::VectorXd spread = Eigen::VectorXd::Zero(n);
  spread.segment((shape.bodies - 1) * plate, plate).setConstant(1.0 / static_cast<double>(plate));
  add_source(network, "motor", 250.0, spread);

  for (int body = 0; body < shape.bodies; ++body) {
    const Eigen::Index here = at(body, shape.columns / 2, 0);
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    row[here] = 0.7;
    row[here + 1] = 0.3;
    const Node& node = network.nodes[static_cast<std::size_t>(here)];
    network.key_points.push_back({"point " + std::to_string(body), node.part, node.r_m, node.z_m, row});
  }
  DeformationOutput nose{"nose", Eigen::VectorXd::Zero(n)};
  for (Eigen::Index i = 0; i < air; ++i) nose.row_m_per_K[i] = uniform(random, -1e-8, 8e-8);
  network.deformations.push_back(nose);
  network.certificate.seed = 42;
  network.certificate.cases = 20;
  network.certificate.worst = {0.11, 0.06, 0.7};
  network.certificate.median = {0.02, 0.01, 0.2};
  return network;
}

Network make_network_with_circuit(const SyntheticShape& shape, std::uint64_t seed) {
  Network network = make_synthetic_network(shape, seed);
  const Eigen::Index n = network.capacity_J_per_K.rows();
  Boundaries& boundaries = network.boundaries;
  CoolantCircuit circuit{"helix", 0, 4180.0, {}};
  for (int body = 0; body < shape.bodies; ++body) {
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(n, shape.columns);
    double area_m2 = 0.0;
    for (int column = 0; column < shape.columns; ++column) {
      const double part_m2 = 0.02 * (1.0 + 0.3 * column + 0.1 * body);
      factor((body * shape.columns + column) * shape.rows, column) = std::sqrt(part_m2);
      area_m2 += part_m2;
    }
    Conductance film;
    film.name = "groove " + std::to_string(body);
    film.kind = ConductanceKind::environment_film;
    film.nominal_W_per_m2K = 900.0;
    film.area_m2 = area_m2;
    film.environment = 0;
    circuit.segments.push_back(static_cast<int>(boundaries.conductances.size()));
    boundaries.conductances.push_back(film);
    network.factors_m.push_back(factor);
  }
  boundaries.circuits = {circuit};
  boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, 0.03);
  return network;
}

Network make_single_node() {
  Network network;
  network.spindle = "single node";
  network.nodes = {{"body", "body", 0.0, 0.0}};
  network.capacity_J_per_K = Eigen::MatrixXd::Constant(1, 1, 1000.0);
  network.conduction_W_per_K = Eigen::MatrixXd::Zero(1, 1);
  network.source_distribution = Eigen::MatrixXd::Ones(1, 1);
  network.boundaries.reference_temperature_K = 300.0;
  network.boundaries.environments = {{"ambient", EnvironmentKind::ambient}};
  network.boundaries.operating.environment_K = Eigen::VectorXd::Constant(1, 300.0);
  network.boundaries.sources = {{"heater", 100.0, {}}};
  Conductance film;
  film.name = "film";
  film.kind = ConductanceKind::environment_film;
  film.nominal_W_per_m2K = 50.0;
  film.area_m2 = 0.5;
  film.environment = 0;
  film.part_a = 0;
  network.boundaries.conductances = {film};
  network.factors_m = {Eigen::MatrixXd::Constant(1, 1, std::sqrt(0.5))};
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  network.key_points = {{"body", "body", 0.0, 0.0, one}};
  network.parts = {{"body", one, Eigen::MatrixXd::Ones(1, 1)}};
  network.deformations = {{"nose", Eigen::VectorXd::Constant(1, 2e-6)}};
  return network;
}

}  // namespace spindle_twin::rom::tests

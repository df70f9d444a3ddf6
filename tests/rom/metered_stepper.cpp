#include "tests/rom/metered_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "rom/boundary_values/held_law.hpp"
#include "rom/require.hpp"

namespace spindle_twin::rom::tests {
namespace {

/// The law of a film's meter: 1 A through 1 ohm, slope · (T − zero_K), exactly linear from zero_K + 10 K on.
constexpr double slope_W_per_K = 0.02;
constexpr double zero_K = 293.15 - 1.0 / slope_W_per_K;

constexpr double largest_rise_K = 500.0;  // of a meter, which then loses digits

Eigen::VectorXd longer(const Eigen::VectorXd& row) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(row.size() + 2);
  result.head(row.size()) = row;
  return result;
}

Eigen::MatrixXd with_rows(const Eigen::MatrixXd& matrix) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(matrix.rows() + 2, matrix.cols());
  result.topRows(matrix.rows()) = matrix;
  return result;
}

/// What the film's factor makes of a wall of 1 K everywhere: area · shape of the mean.
Eigen::VectorXd column_of(const Eigen::MatrixXd& factor_m) { return factor_m * factor_m.colwise().sum().transpose(); }

PhysicalLaw linear_in_temperature() {
  CopperLaw copper;
  copper.copper.phases = 1.0;
  copper.copper.resistance_20_ohm = 1.0;
  copper.copper.temperature_per_K = slope_W_per_K;
  copper.rated_current_A = 1.0;
  return {LawMode::standard, copper};
}

void add_meter_of_film(std::size_t film, Network& to) {
  const Eigen::VectorXd column = column_of(to.factors_m[film]);
  const std::string name = "meter of " + to.boundaries.conductances[film].name;
  PartOutput wall{name, column / column.sum(), {}};
  wall.candidate_rows = wall.mean_row.transpose();
  to.parts.push_back(wall);
  HeatSource source;
  source.name = name;
  source.physics = BoundLaw{linear_in_temperature(), {static_cast<int>(to.parts.size()) - 1, -1, zero_K}, {}};
  to.boundaries.sources.push_back(source);
  const Eigen::Index last = to.source_distribution.cols();
  to.source_distribution.conservativeResize(Eigen::NoChange, last + 1);
  to.source_distribution.col(last) =
      Eigen::VectorXd::Unit(to.source_distribution.rows(), to.source_distribution.rows() - 1);
}

}  // namespace

bool takes_meters(const Network& network) {
  return !has_physics(network.boundaries) && network.boundaries.circuits.empty();
}

Network with_meters(const Network& network) {
  require(takes_meters(network), "meters know neither physical laws nor coolant circuits");
  Network metered = network;
  const Eigen::Index n = network.capacity_J_per_K.rows();
  metered.nodes.push_back({"heat put in", "", 0.0, 0.0});
  metered.nodes.push_back({"heat given away", "", 0.0, 0.0});
  metered.capacity_J_per_K = Eigen::MatrixXd::Zero(n + 2, n + 2);
  metered.capacity_J_per_K.topLeftCorner(n, n) = network.capacity_J_per_K;
  metered.capacity_J_per_K.bottomRightCorner(2, 2).diagonal().setConstant(network.capacity_J_per_K.sum() /
                                                                          static_cast<double>(n));
  metered.conduction_W_per_K = Eigen::MatrixXd::Zero(n + 2, n + 2);
  metered.conduction_W_per_K.topLeftCorner(n, n) = network.conduction_W_per_K;
  for (Eigen::MatrixXd& factor : metered.factors_m) factor = with_rows(factor);
  for (PartOutput& part : metered.parts) part.mean_row = longer(part.mean_row);
  metered.source_distribution = with_rows(network.source_distribution);
  metered.source_distribution.row(n) = network.source_distribution.colwise().sum();
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    if (network.boundaries.conductances[j].environment >= 0) add_meter_of_film(j, metered);
  }
  return metered;
}

MeteredStepper::MeteredStepper(const Network& network, HeatBalance& balance, const CvodeSettings& settings)
    : network_(with_meters(network)),
      nodes_(network.capacity_J_per_K.rows()),
      stepper_(std::make_shared<const NetworkOperator>(network_), settings),
      balance_(balance),
      quadrature_(network),
      temperatures_K_(stepper_.temperatures_K().head(nodes_)),
      before_K_(temperatures_K_),
      all_K_(stepper_.temperatures_K()),
      meters_K_(all_K_.tail(2)) {
  const auto sources = static_cast<Eigen::Index>(network_.boundaries.sources.size());
  for (const HeatSource& source : network.boundaries.sources) nominal_W_ += source.nominal_W;
  values_.heat_W = Eigen::VectorXd::Zero(sources);
  values_.node_heat_W = Eigen::VectorXd::Zero(nodes_ + 2);
  values_.laws.follow = true;
  values_.laws.current_A = 1.0;
  values_.laws.heat_factor = Eigen::VectorXd::Ones(sources);
  values_.laws.conductance_factor = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(network.factors_m.size()));
}

void MeteredStepper::start_meters() {
  all_K_.head(nodes_) = temperatures_K_;
  all_K_.tail(2).setConstant(network_.boundaries.reference_temperature_K);
  stepper_.set_temperatures(all_K_);
}

void MeteredStepper::set_temperatures(const Eigen::VectorXd& temperatures_K) {
  temperatures_K_ = temperatures_K;
  start_meters();
}

/// The inputs with those of the meters. A film's meter has the part of its heat that hangs on the wall from its law,
/// and the rest as a heat into the node.
void MeteredStepper::take(const BoundaryValues& values) {
  values_.conductance_W_per_m2K = values.conductance_W_per_m2K;
  values_.environment_K = values.environment_K;
  values_.coolant_W_per_K = values.coolant_W_per_K;
  values_.heat_W.head(values.heat_W.size()) = values.heat_W;
  values_.node_heat_W.setZero();
  if (values.node_heat_W.size() > 0) {
    values_.node_heat_W.head(nodes_) = values.node_heat_W;
    values_.node_heat_W[nodes_] = values.node_heat_W.sum();
  }
  if (values.capacity_factor.size() > 0) {
    if (values_.capacity_factor.size() == 0) values_.capacity_factor = Eigen::VectorXd::Ones(nodes_ + 2);
    values_.capacity_factor.head(nodes_) = values.capacity_factor;
  } else {
    values_.capacity_factor.resize(0);
  }
  Eigen::Index meter = values.heat_W.size();
  for (std::size_t j = 0; j < network_.factors_m.size(); ++j) {
    const int environment = network_.boundaries.conductances[j].environment;
    if (environment < 0) continue;
    const double area_m2 = network_.factors_m[j].colwise().sum().squaredNorm();
    const double film_W_per_K = values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * area_m2;
    values_.laws.heat_factor[meter++] = film_W_per_K / slope_W_per_K;
    values_.node_heat_W[nodes_ + 1] -= film_W_per_K * (values.environment_K[environment] - zero_K);
  }
}

void MeteredStepper::add_to_balance(double period_s, const BoundaryValues& values) {
  double stored_J = 0.0;
  for (Eigen::Index i = 0; i < nodes_; ++i) {
    const double factor = values.capacity_factor.size() > 0 ? values.capacity_factor[i] : 1.0;
    for (Eigen::Index k = 0; k < nodes_; ++k) {
      stored_J += factor * network_.capacity_J_per_K(i, k) * (temperatures_K_[k] - before_K_[k]);
    }
  }
  const double meter_J_per_K = network_.capacity_J_per_K(nodes_, nodes_);
  const double put_in_J = meter_J_per_K * (stepper_.temperatures_K()[nodes_] - meters_K_[0]);
  const double given_away_J = meter_J_per_K * (stepper_.temperatures_K()[nodes_ + 1] - meters_K_[1]);
  balance_.put_in_J += put_in_J;
  balance_.given_away_J += given_away_J;
  balance_.stored_J += stored_J;
  const double residue_J = std::abs(put_in_J - given_away_J - stored_J);
  balance_.worst_J = std::max(balance_.worst_J, residue_J);
  balance_.worst_share = std::max(balance_.worst_share, residue_J / (nominal_W_ * period_s));
  ++balance_.steps;
  if (period_s > quadrature_longest_s) return;
  const double held_W = values.heat_W.sum() + values.node_heat_W.sum();
  balance_.residue_by_quadrature_J +=
      period_s * held_W - quadrature_.given_away_J(period_s, values, before_K_, temperatures_K_) - stored_J;
}

StepStatus MeteredStepper::advance(double period_s, const BoundaryValues& values) {
  const double rise_K =
      (stepper_.temperatures_K().tail(2).array() - network_.boundaries.reference_temperature_K).abs().maxCoeff();
  if (rise_K > largest_rise_K) start_meters();
  take(values);
  before_K_ = temperatures_K_;
  meters_K_ = stepper_.temperatures_K().tail(2);
  const StepStatus status = stepper_.advance(period_s, values_);
  if (status != StepStatus::ok) return status;
  temperatures_K_ = stepper_.temperatures_K().head(nodes_);
  add_to_balance(period_s, values);
  return status;
}

}  // namespace spindle_twin::rom::tests

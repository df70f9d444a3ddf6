#include "fem_offline/reduce/network_checks.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/coolant.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double rounding = 1e-12;
constexpr double gamma = 1.0 - 1.0 / std::numbers::sqrt2;

double largest(const Eigen::MatrixXd& matrix) { return matrix.size() > 0 ? matrix.cwiseAbs().maxCoeff() : 0.0; }

double asymmetry(const Eigen::MatrixXd& matrix) { return largest(matrix - matrix.transpose()) / largest(matrix); }

/// C dT/dt = u − K T with the inputs of one interval, T counted from the reference temperature, and the heat that
/// leaves through the films, out = a · T − b. The films' heat is summed film by film and segment by segment, not taken
/// from K.
class HeldNetwork {
 public:
  explicit HeldNetwork(const rom::Network& network)
      : network_(network), segments_(rom::coolant_segments(network.boundaries)) {
    for (const Eigen::MatrixXd& factor : network.factors_m) terms_.emplace_back(factor * factor.transpose());
  }

  void hold(const rom::BoundaryValues& values) {
    const double reference_K = network_.boundaries.reference_temperature_K;
    const Eigen::Index n = network_.capacity_J_per_K.rows();
    conduction = network_.conduction_W_per_K;
    drive_W = network_.source_distribution * values.heat_W;
    heat_W = values.heat_W.sum();
    out_W_per_K = Eigen::VectorXd::Zero(n);
    out_at_reference_W = 0.0;
    for (std::size_t j = 0; j < terms_.size(); ++j) {
      const double g = values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)];
      const int environment = network_.boundaries.conductances[j].environment;
      conduction += g * terms_[j];
      if (environment < 0) continue;
      const Eigen::VectorXd wetted = terms_[j].rowwise().sum();
      const double above_K = values.environment_K[environment] - reference_K;
      drive_W += g * above_K * wetted;
      out_W_per_K += g * terms_[j].colwise().sum().transpose();
      out_at_reference_W -= g * above_K * wetted.sum();
    }
    add_circuits(values, reference_K);
  }

  Eigen::MatrixXd conduction;
  Eigen::VectorXd drive_W, out_W_per_K;
  double heat_W = 0.0, out_at_reference_W = 0.0;

 private:
  /// What segments upstream give the liquid comes back to the walls downstream, and leaves no more.
  void add_circuits(const rom::BoundaryValues& values, double reference_K) {
    const Eigen::Index count = segments_.count();
    if (count == 0) return;
    Eigen::MatrixXd upstream(count, count), walls(drive_W.size(), count);
    Eigen::VectorXd inlet_K(count), film(count), areas(count);
    rom::coolant_upstream(segments_, values, upstream);
    for (Eigen::Index s = 0; s < count; ++s) {
      const auto segment = static_cast<std::size_t>(s);
      walls.col(s) = terms_[static_cast<std::size_t>(segments_.conductance[segment])].rowwise().sum();
      areas[s] = walls.col(s).sum();
      film[s] = values.conductance_W_per_m2K[segments_.conductance[segment]];
      inlet_K[s] = values.environment_K[segments_.inlet[segment]] - reference_K;
    }
    const Eigen::MatrixXd fed = upstream * areas.cwiseInverse().asDiagonal() * walls.transpose();
    conduction -= walls * film.asDiagonal() * fed;
    drive_W -= walls * film.asDiagonal() * (upstream * inlet_K);
    const Eigen::VectorXd given_W_per_K = film.cwiseProduct(areas);
    out_W_per_K -= fed.transpose() * given_W_per_K;
    out_at_reference_W += given_W_per_K.dot(upstream * inlet_K);
  }

  const rom::Network& network_;
  rom::CoolantSegments segments_;
  std::vector<Eigen::MatrixXd> terms_;
};

bool is_definite(const Eigen::MatrixXd& matrix) {
  return Eigen::LLT<Eigen::MatrixXd>(0.5 * (matrix + matrix.transpose())).info() == Eigen::Success;
}

}  // namespace

bool NetworkChecks::passed() const {
  return asymmetry <= rounding && capacity_definite && conduction_definite && row_sum <= rounding &&
         exchange_sum <= rounding && source_sum <= rounding && heat_balance <= most_heat_unbalanced;
}

double heat_unbalanced(const rom::Network& network, const DriveCase& drive) {
  const rom::Boundaries& boundaries = network.boundaries;
  const Eigen::MatrixXd& capacity = network.capacity_J_per_K;
  const Eigen::VectorXd stored_J_per_K = capacity.colwise().sum();
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::CorrectionFactors factors = drive.factors;
  HeldNetwork held(network);
  Eigen::VectorXd rise_K =
      Eigen::VectorXd::Constant(capacity.rows(), drive.initial_temperature_K - boundaries.reference_temperature_K);
  const double stored_before_J = stored_J_per_K.dot(rise_K);
  double heat_J = 0.0, left_J = 0.0, given_J = 0.0;
  for (const HeldInterval& interval : drive.intervals) {
    if (interval.conductance_factors.size() > 0) factors.conductance = interval.conductance_factors;
    rom::evaluate_boundaries(boundaries, interval.state, factors, values);
    held.hold(values);
    const double h_s = interval.duration_s;
    const Eigen::PartialPivLU<Eigen::MatrixXd> stage(capacity + gamma * h_s * held.conduction);
    const auto out_W = [&](const Eigen::VectorXd& at_K) {
      return held.out_W_per_K.dot(at_K) + held.out_at_reference_W;
    };
    // Stages T₁ = T + γh k₁, T₂ = T + h ((1 − γ) k₁ + γ k₂), kᵢ = C⁻¹(u − K Tᵢ).
    const Eigen::VectorXd first_K = stage.solve(capacity * rise_K + gamma * h_s * held.drive_W);
    const Eigen::VectorXd until_K = rise_K + (1.0 - gamma) / gamma * (first_K - rise_K);
    const Eigen::VectorXd second_K = stage.solve(capacity * until_K + gamma * h_s * held.drive_W);
    const double out_J = h_s * ((1.0 - gamma) * out_W(first_K) + gamma * out_W(second_K));
    heat_J += h_s * held.heat_W;
    left_J += out_J;
    given_J += std::max(0.0, -out_J);
    rise_K = second_K;
  }
  return std::abs(heat_J - left_J - (stored_J_per_K.dot(rise_K) - stored_before_J)) / (heat_J + given_J);
}

NetworkChecks check_laws(const rom::Network& network, const std::vector<DriveCase>& drives) {
  NetworkChecks checks;
  checks.asymmetry = std::max(asymmetry(network.capacity_J_per_K), asymmetry(network.conduction_W_per_K));
  checks.capacity_definite = is_definite(network.capacity_J_per_K);
  const rom::Boundaries& boundaries = network.boundaries;
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, boundaries.operating, rom::no_correction(boundaries), values);
  Eigen::MatrixXd conduction = network.conduction_W_per_K;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const Eigen::MatrixXd& factor = network.factors_m[j];
    conduction += values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * factor * factor.transpose();
    checks.largest_rank = std::max(checks.largest_rank, factor.cols());
    if (boundaries.conductances[j].environment < 0) {
      checks.exchange_sum = std::max(checks.exchange_sum, largest(factor.colwise().sum()) / largest(factor));
    }
  }
  checks.conduction_definite = is_definite(conduction);
  checks.row_sum = largest(network.conduction_W_per_K.rowwise().sum()) / largest(network.conduction_W_per_K);
  checks.source_sum = largest(network.source_distribution.colwise().sum().array() - 1.0);
  for (const DriveCase& drive : drives) {
    checks.heat_balance = std::max(checks.heat_balance, heat_unbalanced(network, drive));
  }
  return checks;
}

}  // namespace spindle_twin::fem_offline

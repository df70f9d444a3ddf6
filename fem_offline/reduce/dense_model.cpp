#include "fem_offline/reduce/dense_model.hpp"

#include <Eigen/LU>
#include <utility>

namespace spindle_twin::fem_offline {

void PackedTerms::set(Eigen::Index term, const Eigen::MatrixXd& matrix) {
  auto values = values_.col(term);
  for (Eigen::Index c = 0; c < size_; ++c) values.segment(start_of(c), size_ - c) = matrix.col(c).tail(size_ - c);
}

PackedTerms PackedTerms::first(Eigen::Index size) const {
  PackedTerms result(size, count());
  for (Eigen::Index term = 0; term < count(); ++term) {
    auto values = result.values_.col(term);
    for (Eigen::Index c = 0; c < size; ++c)
      values.segment(result.start_of(c), size - c) = column(term, c).head(size - c);
  }
  return result;
}

PackedTerms PackedTerms::sums(const Eigen::MatrixXd& weights) const {
  PackedTerms result;
  result.size_ = size_;
  result.values_ = product(values_, weights);
  return result;
}

void PackedTerms::add_to_lower(Eigen::Index term, Eigen::MatrixXd& matrix) const {
  for (Eigen::Index c = 0; c < size_; ++c) matrix.col(c).tail(size_ - c) += column(term, c);
}

namespace {

/// What the liquid carries from segment to segment: H = S Γ U, W = S A⁻¹, drive −= S Γ U T_inlet.
void couple(const DenseModel& model, const rom::CoolantSegments& segments, const rom::BoundaryValues& values,
            double zero_K, HeldModel& held) {
  const Eigen::Index count = segments.count();
  Eigen::MatrixXd upstream(count, count);
  Eigen::VectorXd inlet_K(count), film_W_per_m2K(count);
  rom::coolant_upstream(segments, values, upstream);
  for (Eigen::Index s = 0; s < count; ++s) {
    const auto segment = static_cast<std::size_t>(s);
    film_W_per_m2K[s] = values.conductance_W_per_m2K[segments.conductance[segment]];
    inlet_K[s] = values.environment_K[segments.inlet[segment]] - zero_K;
  }
  const Eigen::MatrixXd walls_m2 = model.walls_m2(Eigen::all, segments.conductance);
  held.carried = walls_m2 * film_W_per_m2K.asDiagonal() * upstream;
  held.walls = walls_m2 * segments.area_m2.cwiseInverse().asDiagonal();
  held.drive -= held.carried * inlet_K;
}

/// Adds to the lower triangle of K what the conductances have gained; column by column, so that of K each is in the
/// cache.
void add_gained(const DenseModel& model, const std::vector<std::pair<Eigen::Index, double>>& gained_W_per_m2K,
                Eigen::MatrixXd& conduction) {
  const Eigen::Index size = conduction.rows();
  for (Eigen::Index c = 0; c < size; ++c) {
    auto column = conduction.col(c).tail(size - c);
    for (const auto& [j, gain_W_per_m2K] : gained_W_per_m2K) {
      column += gain_W_per_m2K * model.conductance_terms.column(j, c);
    }
  }
}

}  // namespace

DenseModel first_states(const DenseModel& model, Eigen::Index size) {
  return {.capacity = model.capacity.topLeftCorner(size, size),
          .conduction = model.conduction.topLeftCorner(size, size),
          .conductance_terms = model.conductance_terms.first(size),
          .walls_m2 = model.walls_m2.topRows(size),
          .source_distribution = model.source_distribution.topRows(size),
          .uniform = model.uniform.head(size)};
}

DenseModel dense_model_of(const rom::Network& network) {
  DenseModel model;
  model.capacity = network.capacity_J_per_K;
  model.conduction = network.conduction_W_per_K;
  model.walls_m2.resize(model.capacity.rows(), static_cast<Eigen::Index>(network.factors_m.size()));
  model.conductance_terms = PackedTerms(model.capacity.rows(), model.walls_m2.cols());
  for (Eigen::Index j = 0; j < model.walls_m2.cols(); ++j) {
    const Eigen::MatrixXd& factor = network.factors_m[static_cast<std::size_t>(j)];
    model.walls_m2.col(j) = factor * factor.colwise().sum().transpose();
    model.conductance_terms.set(j, product_with_transposed(factor));
  }
  model.source_distribution = network.source_distribution;
  model.uniform.setOnes(model.capacity.rows());
  return model;
}

HeldModel hold_conductances(const DenseModel& model, const PackedTerms& sums, Eigen::Index sum,
                            const Eigen::VectorXd& conductances_W_per_m2K) {
  HeldModel held;
  held.conduction = model.conduction;
  sums.add_to_lower(sum, held.conduction);
  held.contained_W_per_m2K = conductances_W_per_m2K;
  return held;
}

void hold_inputs(const DenseModel& model, const rom::Boundaries& boundaries, const rom::CoolantSegments& segments,
                 const rom::BoundaryValues& values, double zero_K, HeldModel& held) {
  const Eigen::Index count = model.conductance_terms.count();
  if (held.contained_W_per_m2K.size() != count) {
    held.conduction = model.conduction;
    held.contained_W_per_m2K.setZero(count);
  }
  held.carried.resize(model.conduction.rows(), 0);
  held.walls.resize(model.conduction.rows(), 0);
  held.drive = model.source_distribution * values.heat_W;
  std::vector<std::pair<Eigen::Index, double>> gained_W_per_m2K;
  for (Eigen::Index j = 0; j < count; ++j) {
    const double g = values.conductance_W_per_m2K[j];
    const int environment = boundaries.conductances[static_cast<std::size_t>(j)].environment;
    const double gain_W_per_m2K = g - held.contained_W_per_m2K[j];
    if (gain_W_per_m2K != 0.0) gained_W_per_m2K.emplace_back(j, gain_W_per_m2K);
    held.contained_W_per_m2K[j] = g;
    if (environment >= 0) held.drive += g * (values.environment_K[environment] - zero_K) * model.walls_m2.col(j);
  }
  add_gained(model, gained_W_per_m2K, held.conduction);
  if (segments.count() > 0) couple(model, segments, values, zero_K, held);
}

namespace {

/// The lower triangle of K + rate · C; what stands above is not set.
Eigen::MatrixXd lower_of_sum(const Eigen::MatrixXd& conduction, double rate_per_s, const Eigen::MatrixXd& capacity) {
  const Eigen::Index size = conduction.rows();
  Eigen::MatrixXd sum(size, size);
  for (Eigen::Index c = 0; c < size; ++c) {
    sum.col(c).tail(size - c) = conduction.col(c).tail(size - c) + rate_per_s * capacity.col(c).tail(size - c);
  }
  return sum;
}

}  // namespace

ShiftedModel::ShiftedModel(const DenseModel& model, const HeldModel& held, double rate_per_s)
    : symmetric_(lower_of_sum(held.conduction, rate_per_s, model.capacity), "the reduced conduction matrix"),
      carried_(held.carried),
      walls_(held.walls) {}

namespace {

/// (A − H Wᵀ)⁻¹ F = X + Y (1 − WᵀY)⁻¹ WᵀX with X = A⁻¹F, Y = A⁻¹H.
Eigen::MatrixXd solve_beside(const DenseCholesky& symmetric, const Eigen::MatrixXd& left, const Eigen::MatrixXd& right,
                             const Eigen::MatrixXd& heat) {
  const Eigen::Index rank = left.cols();
  if (rank == 0) return symmetric.solve(heat);
  Eigen::MatrixXd both(heat.rows(), heat.cols() + rank);
  both << heat, left;
  both = symmetric.solve(std::move(both));
  const auto response = both.rightCols(rank);
  const Eigen::MatrixXd small = Eigen::MatrixXd::Identity(rank, rank) - right.transpose() * response;
  return both.leftCols(heat.cols()) +
         response * small.partialPivLu().solve((right.transpose() * both.leftCols(heat.cols())).eval());
}

}  // namespace

Eigen::VectorXd ShiftedModel::solve(const Eigen::VectorXd& heat_W) const {
  return solve_beside(symmetric_, carried_, walls_, heat_W);
}

Eigen::MatrixXd ShiftedModel::solve_transposed(const Eigen::MatrixXd& rows) const {
  return solve_beside(symmetric_, walls_, carried_, rows);
}

rom::OperatingState random_state(const rom::Boundaries& boundaries, const ParameterBox& box, const StateDraw& draw,
                                 RandomStream& random) {
  rom::OperatingState state = boundaries.operating;
  state.speed_rpm = random.uniform(0.0, box.speed_high_rpm);
  state.load = random.uniform(0.0, box.load_high);
  for (double& environment_K : state.environment_K) environment_K += random.uniform(-draw.spread_K, draw.spread_K);
  state.flow_kg_per_s = random_flow_kg_per_s(boundaries, box, random);
  if (draw.rest_share > 0.0 && random.uniform(0.0, 1.0) < draw.rest_share) state.speed_rpm = state.load = 0.0;
  if (draw.coolant == Coolant::stands) state.flow_kg_per_s.setZero();
  if (draw.coolant != Coolant::flows) return state;
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    double& flow_kg_per_s = state.flow_kg_per_s[static_cast<Eigen::Index>(c)];
    if (flow_kg_per_s == 0.0) flow_kg_per_s = box.flow_low * flow_scale_kg_per_s(boundaries, c);
  }
  return state;
}

}  // namespace spindle_twin::fem_offline

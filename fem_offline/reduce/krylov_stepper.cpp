#include "fem_offline/reduce/krylov_stepper.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <optional>
#include <utility>
#include <vector>

#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "fem_offline/solve/held_system.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// (C + pole A)⁻¹ C: from the seconds in which balls and air follow a jump to the minutes of the housing.
constexpr std::array poles_s = {0.5, 8.0, 128.0};
constexpr int first_judged_round = 4;  ///< none has been enough before
constexpr int usual_rounds = 6;        ///< to 9
constexpr int most_rounds = 16;        ///< then steps in time are the surer way
constexpr double in_span = 1e-10;      ///< what is left of a vector that the space had already

/// Loads of a stretch: that of its first part, and how those of the others differ from it.
struct StretchLoads {
  Eigen::MatrixXd columns_W;  ///< first less what leaves at the start; then directions of surroundings that move
  Eigen::MatrixXd shares;     ///< of each part (column) in these
};

/// Directions in which surroundings move along a stretch: orthonormal columns. [1]
Eigen::MatrixXd directions_of(std::span<const StretchPart> parts) {
  const Eigen::VectorXd& first = parts.front().values.environment_K;
  Eigen::MatrixXd found(first.size(), 0);
  for (const StretchPart& part : parts) {
    Eigen::VectorXd moved = part.values.environment_K - first;
    const double size = moved.norm();
    moved -= found * (found.transpose() * moved);
    if (!(moved.norm() > in_span * std::max(size, 1.0))) continue;
    found.conservativeResize(Eigen::NoChange, found.cols() + 1);
    found.rightCols(1) = moved.normalized();
  }
  return found;
}

/// (eˣ − 1) / x
std::complex<double> mean_of_exponential(std::complex<double> x) {
  constexpr double small = 1e-6;
  return std::abs(x) < small ? 1.0 + 0.5 * x : (std::exp(x) - 1.0) / x;
}

/// dy/dt = f − A y in the eigenvectors of A, in real numbers.
struct DecayModes {
  RealModes modes;
  bool symmetric;  ///< then S⁻¹ = Sᵀ

  Eigen::MatrixXd to_modes(const Eigen::MatrixXd& columns) const {
    if (symmetric) return modes.vectors.transpose() * columns;
    return Eigen::PartialPivLU<Eigen::MatrixXd>(modes.vectors).solve(columns);
  }

  /// Amplitudes after this time with f held. Those of a pair of complex modes p ± iq with eigenvalues α ± iβ are real
  /// and imaginary part of one z: dz/dt = f_p + i f_q − (α − iβ) z.
  void advance(double duration_s, const Eigen::VectorXd& driven, Eigen::VectorXd& amplitude) const {
    for (Eigen::Index k = 0; k < driven.size(); ++k) {
      const bool pair = modes.imaginary[k] != 0.0;
      const std::complex<double> decay = -duration_s * std::complex(modes.real[k], -modes.imaginary[k]);
      std::complex<double> own(amplitude[k], pair ? amplitude[k + 1] : 0.0);
      const std::complex<double> drive(driven[k], pair ? driven[k + 1] : 0.0);
      own = std::exp(decay) * own + duration_s * mean_of_exponential(decay) * drive;
      amplitude[k] = own.real();
      if (pair) amplitude[++k] = own.imag();
    }
  }
};

DecayModes decay_modes_of(const Eigen::MatrixXd& matrix, bool symmetric) {
  if (!symmetric) return {real_modes(matrix), false};
  SymmetricModes modes = symmetric_modes(matrix);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(modes.values.size());
  return {{std::move(modes.values), none, std::move(modes.vectors)}, true};
}

}  // namespace

bool of_one_stretch(const rom::BoundaryValues& one, const rom::BoundaryValues& other) {
  return one.conductance_W_per_m2K == other.conductance_W_per_m2K && one.heat_W == other.heat_W &&
         one.coolant_W_per_K == other.coolant_W_per_K;
}

struct KrylovStepper::Impl {
  Impl(const AffineModel& of, const CholeskyAnalysis& shared, double tolerance)
      : model(of), analysed(shared), tolerance_K(tolerance), system(of) {}

  const AffineModel& model;
  const CholeskyAnalysis& analysed;
  double tolerance_K;
  HeldSystem system;
  Eigen::VectorXd temperatures_K;
  /// V with Vᵀ C V = 1, C V, A V and Vᵀ A V, of which the first `used` columns belong to this stretch. The next one
  /// writes over them.
  Eigen::MatrixXd space_buffer, stored_buffer, conducted_buffer, projected_buffer;
  Eigen::Index used = 0;

  auto space() const { return space_buffer.leftCols(used); }
  auto stored() const { return stored_buffer.leftCols(used); }
  auto projected() const { return projected_buffer.topLeftCorner(used, used); }

  /// Room for so many columns; those in use stay.
  void make_room(Eigen::Index columns) {
    if (space_buffer.cols() >= columns) return;
    for (Eigen::MatrixXd* buffer : {&space_buffer, &stored_buffer, &conducted_buffer}) {
      buffer->conservativeResize(temperatures_K.size(), columns);
    }
    projected_buffer.conservativeResize(columns, columns);
  }

  /// Without liquid that carries heat from wall to wall A is symmetric.
  bool symmetric() const { return system.circuits().empty(); }

  StretchLoads loads_of(std::span<const StretchPart> parts) {
    const Eigen::MatrixXd directions = directions_of(parts);
    StretchLoads loads;
    loads.columns_W.resize(temperatures_K.size(), 1 + directions.cols());
    rom::BoundaryValues values = parts.front().values;
    for (Eigen::Index i = 0; i < directions.cols(); ++i) {
      values.environment_K = parts.front().values.environment_K + directions.col(i);
      system.hold(values, 0.0);
      loads.columns_W.col(1 + i) = system.load_W();
    }
    system.hold(parts.front().values, 0.0);  // and so it stays for the stretch
    loads.columns_W.rightCols(directions.cols()).colwise() -= system.load_W();
    loads.columns_W.col(0) = system.load_W() - system.conducted_W(temperatures_K);
    loads.shares.resize(1 + directions.cols(), static_cast<Eigen::Index>(parts.size()));
    loads.shares.row(0).setOnes();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      loads.shares.col(static_cast<Eigen::Index>(i)).tail(directions.cols()) =
          directions.transpose() * (parts[i].values.environment_K - parts.front().values.environment_K);
    }
    return loads;
  }

  /// Solutions with every pole in turn, each of C times what the one before gave, and C times all of them; `right`: for
  /// the first pole. The last ones stand in the last columns.
  void next_block(std::vector<CoupledFactor>& factors, const Eigen::MatrixXd& right, Eigen::MatrixXd& block,
                  Eigen::MatrixXd& stored_block) const {
    const Eigen::Index count = right.cols();
    block.resize(right.rows(), static_cast<Eigen::Index>(factors.size()) * count);
    stored_block.resize(block.rows(), block.cols());
    for (std::size_t pole = 0; pole < factors.size(); ++pole) {
      const Eigen::Index first = static_cast<Eigen::Index>(pole) * count;
      const Eigen::MatrixXd loads_W = pole == 0 ? right : stored_block.middleCols(first - count, count);
      block.middleCols(first, count) = factors[pole].solve(loads_W, system.circuits());
      stored_block.middleCols(first, count) = system.stored_J(block.middleCols(first, count));
    }
  }

  /// C-orthonormal against the space and each other (Gram-Schmidt, twice), C times the block with it; columns that are
  /// in the span become zero.
  void orthonormalise(Eigen::MatrixXd& block, Eigen::MatrixXd& stored_block) const {
    for (Eigen::Index j = 0; j < block.cols(); ++j) {
      const double norm = std::sqrt(block.col(j).dot(stored_block.col(j)));
      if (norm > 0.0) block.col(j) /= norm, stored_block.col(j) /= norm;
    }
    for (int pass = 0; pass < 2; ++pass) {
      if (used > 0) {
        const Eigen::MatrixXd shares = transposed_product(space(), stored_block);
        block -= product(space(), shares);
        stored_block -= product(stored(), shares);
      }
      for (Eigen::Index j = 0; j < block.cols(); ++j) {
        for (Eigen::Index i = 0; i < j; ++i) {
          const double share = block.col(i).dot(stored_block.col(j));
          block.col(j) -= share * block.col(i);
          stored_block.col(j) -= share * stored_block.col(i);
        }
        const double left = std::sqrt(std::max(block.col(j).dot(stored_block.col(j)), 0.0));
        const double scale = left > in_span ? 1.0 / left : 0.0;
        block.col(j) *= scale, stored_block.col(j) *= scale;
      }
    }
  }

  void enlarge(const Eigen::MatrixXd& block, const Eigen::MatrixXd& stored_block) {
    const Eigen::Index before = used, more = block.cols();
    make_room(before + more);
    used += more;
    space_buffer.middleCols(before, more) = block;
    stored_buffer.middleCols(before, more) = stored_block;
    conducted_buffer.middleCols(before, more) = system.conducted_W(block);
    projected_buffer.block(0, before, used, more) =
        transposed_product(space(), conducted_buffer.middleCols(before, more));
    if (symmetric()) {
      projected_buffer.block(before, 0, more, before) = projected_buffer.block(0, before, before, more).transpose();
    } else {
      projected_buffer.block(before, 0, more, before) = transposed_product(block, conducted_buffer.leftCols(before));
    }
  }

  std::vector<CoupledFactor> factors() const {
    std::vector<CoupledFactor> made;
    made.reserve(poles_s.size());
    for (const double pole_s : poles_s) made.push_back(system.factor(pole_s, &analysed));
    return made;
  }

  /// The solution in the space at the end of every part, exact in time: by the modes of the projected matrix.
  Eigen::MatrixXd solution(std::span<const StretchPart> parts, const StretchLoads& loads) const {
    const DecayModes decay = decay_modes_of(projected(), symmetric());
    const Eigen::MatrixXd driven = decay.to_modes(transposed_product(space(), loads.columns_W) * loads.shares);
    Eigen::MatrixXd amplitudes(driven.rows(), driven.cols());
    Eigen::VectorXd amplitude = Eigen::VectorXd::Zero(driven.rows());
    for (Eigen::Index i = 0; i < driven.cols(); ++i) {
      decay.advance(parts[static_cast<std::size_t>(i)].duration_s, driven.col(i), amplitude);
      amplitudes.col(i) = amplitude;
    }
    return decay.modes.vectors * amplitudes;
  }

  /// Largest difference that the last columns of the space have made, at the ends of some parts. [K]
  double change_K(const Eigen::MatrixXd& before, const Eigen::MatrixXd& now) const {
    const Eigen::Index last = now.cols() - 1;
    Eigen::MatrixXd changes(now.rows(), 4);
    Eigen::Index column = 0;
    for (const Eigen::Index part : {Eigen::Index{0}, std::min<Eigen::Index>(2, last), last / 2, last}) {
      changes.col(column) = now.col(part);
      changes.col(column++).head(before.rows()) -= before.col(part);
    }
    return product(space(), changes).cwiseAbs().maxCoeff();
  }

  /// The change of every unknown's temperature until the end of every part; nothing where the space has grown too
  /// large.
  std::optional<Eigen::MatrixXd> changes_K(std::span<const StretchPart> parts) {
    const StretchLoads loads = loads_of(parts);
    std::vector<CoupledFactor> of_poles = factors();
    Eigen::MatrixXd right = loads.columns_W, before, block, stored_block;
    used = 0;
    make_room(usual_rounds * static_cast<Eigen::Index>(of_poles.size()) * right.cols());
    for (int round = 1; round <= most_rounds; ++round) {
      next_block(of_poles, right, block, stored_block);
      orthonormalise(block, stored_block);
      enlarge(block, stored_block);
      right = stored_block.rightCols(right.cols()).eval();
      if (round < first_judged_round - 1) continue;
      const Eigen::MatrixXd now = solution(parts, loads);
      if (round >= first_judged_round && change_K(before, now) <= tolerance_K) return product(space(), now);
      before = now;
    }
    return {};
  }
};

KrylovStepper::KrylovStepper(const AffineModel& model, const CholeskyAnalysis& analysed, double tolerance_K)
    : impl_(std::make_unique<Impl>(model, analysed, tolerance_K)) {}
KrylovStepper::~KrylovStepper() = default;

void KrylovStepper::set_temperatures(const Eigen::VectorXd& temperatures_K) { impl_->temperatures_K = temperatures_K; }
const Eigen::VectorXd& KrylovStepper::temperatures_K() const { return impl_->temperatures_K; }

void KrylovStepper::advance(std::span<const StretchPart> parts,
                            const std::function<void(std::size_t, const Eigen::VectorXd&)>& visit) {
  const Eigen::VectorXd start_K = impl_->temperatures_K;
  if (const std::optional<Eigen::MatrixXd> changes_K = impl_->changes_K(parts)) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      impl_->temperatures_K = start_K + changes_K->col(static_cast<Eigen::Index>(i));
      visit(i, impl_->temperatures_K);
    }
    return;
  }
  FeStepper stepper(impl_->model, FeScheme::order_4, &impl_->analysed);
  stepper.set_temperatures(start_K);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    stepper.advance_within(parts[i].duration_s, impl_->tolerance_K, parts[i].values);
    impl_->temperatures_K = stepper.temperatures_K();
    visit(i, impl_->temperatures_K);
  }
}

}  // namespace spindle_twin::fem_offline

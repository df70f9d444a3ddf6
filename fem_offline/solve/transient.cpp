#include <algorithm>
#include <cmath>
#include <list>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "fem_offline/solve/fe_solver.hpp"
#include "fem_offline/solve/held_system.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Stages kᵢ of (C + γhK) kᵢ = f − K (T + h Σⱼ<ᵢ aᵢⱼ kⱼ) with one γ; the last row of `a` with γ is also that of the
/// weights (stiffly accurate).
struct Tableau {
  double gamma;
  Eigen::MatrixXd below;
  Eigen::VectorXd error;  ///< weights less those of the embedded rule of one order less; empty where there is none
  double share_of_time_since_jump = 1.0 / 3.0;  ///< longest step
  long growth = 2;                              ///< a step is so many times as long as the next shorter one
};

/// γ = 1 − 1/√2.
Tableau order_2() {
  constexpr double gamma = 1.0 - 1.0 / std::numbers::sqrt2;
  Eigen::MatrixXd below = Eigen::MatrixXd::Zero(2, 2);
  below(1, 0) = 1.0 - gamma;
  return {gamma, below, {}};
}

/// Hairer, Wanner: Solving Ordinary Differential Equations II, table IV.6.5.
Tableau order_4() {
  Eigen::MatrixXd below = Eigen::MatrixXd::Zero(5, 5);
  below(1, 0) = 1.0 / 2.0;
  below.row(2).head(2) << 17.0 / 50.0, -1.0 / 25.0;
  below.row(3).head(3) << 371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0;
  below.row(4).head(4) << 25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0;
  Eigen::VectorXd error(5);
  error << 25.0 / 24.0 - 59.0 / 48.0, -49.0 / 48.0 + 17.0 / 96.0, 125.0 / 16.0 - 225.0 / 32.0, 0.0, 0.25;
  // A factor costs as much as two steps, and steps that double would need twice as many factors. In four certificate
  // cases of the reference spindle this left 1e-3 K in the balls, which follow a jump fastest, and 1e-5 um.
  return {0.25, below, error, 1.0 / 2.0, 4};
}

// After a jump the steps start at about this length and then follow the time since the jump.
constexpr double first_step_s = 0.7;
constexpr long most_ticks = 256;  // in one of the longest steps
// Steps that follow a tolerance: after a jump the first is at most this long; one that errs by less than this share of
// the tolerance is followed by one twice as long, for the error of a step of twice the length is 16 times as large.
constexpr double first_controlled_step_s = 0.05;
constexpr double share_for_longer = 1.0 / 32.0;
constexpr int most_halvings = 12;
// Slower drifts of an environment or a conductance are no jump.
constexpr double environment_jump_K = 0.5;
constexpr double conductance_jump_share = 0.05;

bool jumped(const Eigen::VectorXd& before, const Eigen::VectorXd& now) {
  return ((now - before).array().abs() > conductance_jump_share * before.array().abs().max(now.array().abs())).any();
}

struct KeptFactor {
  double step_s;
  Eigen::VectorXd conductance_W_per_m2K;
  Eigen::VectorXd coolant_W_per_K;
  CoupledFactor factor;
};

}  // namespace

Eigen::VectorXd initial_temperatures(const AffineModel& model, double otherwise_K) {
  Eigen::VectorXd temperatures_K = Eigen::VectorXd::Constant(model.capacity_J_per_K.rows(), otherwise_K);
  for (const FePart& part : model.parts) {
    if (!part.initial_K) continue;
    for (const int dof : part.dofs) temperatures_K[dof] = *part.initial_K;
  }
  return temperatures_K;
}

struct FeStepper::Impl {
  Impl(const AffineModel& model, FeScheme scheme, const CholeskyAnalysis* shared)
      : system(model),
        analysed(shared),
        tableau(scheme == FeScheme::order_4 ? order_4() : order_2()),
        slopes_K_per_s(static_cast<std::size_t>(tableau.below.rows())) {}

  HeldSystem system;
  const CholeskyAnalysis* analysed;
  rom::BoundaryValues held;
  double since_jump_s = 0.0;
  double controlled_step_s = first_controlled_step_s;
  Eigen::VectorXd temperatures_K;
  std::list<KeptFactor> factors;  // the most recent first
  std::size_t most_factors = 16;
  Tableau tableau;
  std::vector<Eigen::VectorXd> slopes_K_per_s;
  Eigen::VectorXd residual_W, stage_K;

  void take(const rom::BoundaryValues& values) {
    const bool is_first = held.heat_W.size() == 0;
    const bool jump = is_first || jumped(held.conductance_W_per_m2K, values.conductance_W_per_m2K) ||
                      held.coolant_W_per_K != values.coolant_W_per_K || held.heat_W != values.heat_W ||
                      (held.environment_K - values.environment_K).lpNorm<Eigen::Infinity>() > environment_jump_K;
    if (jump) since_jump_s = 0.0, controlled_step_s = first_controlled_step_s;
    held = values;
    system.hold(values, 0.0);
  }

  CoupledFactor& factor_for(double step_s) {
    const auto found = std::find_if(factors.begin(), factors.end(), [&](const KeptFactor& kept) {
      return kept.step_s == step_s && kept.conductance_W_per_m2K == held.conductance_W_per_m2K &&
             kept.coolant_W_per_K == held.coolant_W_per_K;
    });
    if (found != factors.end()) {
      factors.splice(factors.begin(), factors, found);
      return factors.front().factor;
    }
    const CholeskyAnalysis* known = factors.empty() ? analysed : &factors.front().factor.symmetric().analysis();
    factors.push_front(
        {step_s, held.conductance_W_per_m2K, held.coolant_W_per_K, system.factor(tableau.gamma * step_s, known)});
    while (factors.size() > most_factors) factors.pop_back();
    return factors.front().factor;
  }

  void step(double step_s) {
    CoupledFactor& factor = factor_for(step_s);
    for (std::size_t i = 0; i < slopes_K_per_s.size(); ++i) {
      stage_K = temperatures_K;
      for (std::size_t j = 0; j < i; ++j) {
        stage_K +=
            step_s * tableau.below(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * slopes_K_per_s[j];
      }
      system.net_heat_W(stage_K, residual_W);
      factor.solve(residual_W, system.circuits(), slopes_K_per_s[i]);
    }
    temperatures_K = stage_K + tableau.gamma * step_s * slopes_K_per_s.back();
  }

  /// Largest difference from the embedded rule, of the step just made, through (C + γhK)⁻¹C (L. F. Shampine): the
  /// embedded rule does not damp what decays within the step, and would take it for an error.
  double step_error_K(double step_s) {
    stage_K.setZero();
    for (std::size_t i = 0; i < slopes_K_per_s.size(); ++i) {
      stage_K += step_s * tableau.error[static_cast<Eigen::Index>(i)] * slopes_K_per_s[i];
    }
    residual_W = system.stored_J(stage_K);
    factor_for(step_s).solve(residual_W, system.circuits(), stage_K);
    return stage_K.lpNorm<Eigen::Infinity>();
  }
};

FeStepper::FeStepper(const AffineModel& model, FeScheme scheme, const CholeskyAnalysis* analysed)
    : impl_(std::make_unique<Impl>(model, scheme, analysed)) {
  set_temperatures(initial_temperatures(model, model.boundaries.reference_temperature_K));
}
FeStepper::~FeStepper() = default;
FeStepper::FeStepper(FeStepper&&) noexcept = default;
FeStepper& FeStepper::operator=(FeStepper&&) noexcept = default;

void FeStepper::keep_factors(std::size_t most) { impl_->most_factors = std::max<std::size_t>(most, 1); }

void FeStepper::set_temperatures(const Eigen::VectorXd& temperatures_K) {
  impl_->temperatures_K = temperatures_K;
  impl_->since_jump_s = 0.0;
  impl_->controlled_step_s = first_controlled_step_s;
}

void FeStepper::set_uniform_temperature(double temperature_K) {
  set_temperatures(Eigen::VectorXd::Constant(impl_->temperatures_K.size(), temperature_K));
}

void FeStepper::advance(double period_s, double max_step_s, const rom::BoundaryValues& values) {
  if (period_s <= 0.0) return;
  impl_->take(values);
  // All steps are longest / growth^k on one grid of ticks, so that few factors serve them all.
  const auto longest_count = static_cast<long>(std::ceil(period_s / max_step_s - 1e-9));
  const double longest_s = period_s / static_cast<double>(longest_count);
  const long growth = impl_->tableau.growth;
  long longest_ticks = 1;
  while (longest_ticks < most_ticks && longest_s > first_step_s * static_cast<double>(longest_ticks)) {
    longest_ticks *= growth;
  }
  const double tick_s = longest_s / static_cast<double>(longest_ticks);
  const long end = longest_count * longest_ticks;
  for (long at = 0; at < end;) {
    const double wanted_s = impl_->tableau.share_of_time_since_jump * impl_->since_jump_s * (1.0 + 1e-9);
    long ticks = longest_ticks;
    while (ticks > 1 && (at % ticks != 0 || static_cast<double>(ticks) * tick_s > wanted_s)) ticks /= growth;
    const double step_s = static_cast<double>(ticks) * tick_s;
    impl_->step(step_s);
    impl_->since_jump_s += step_s;
    at += ticks;
  }
}

void FeStepper::advance_within(double period_s, double tolerance_K, const rom::BoundaryValues& values) {
  if (impl_->tableau.error.size() == 0) throw std::logic_error("only the rule of order 4 knows its error");
  if (period_s <= 0.0) return;
  impl_->take(values);
  // All steps are period / 2^k on one grid of ticks, so that few factors serve them all.
  const long end = 1L << most_halvings;
  const double tick_s = period_s / static_cast<double>(end);
  Eigen::VectorXd before_K;
  for (long at = 0; at < end;) {
    long ticks = end;
    while (ticks > 1 &&
           (at % ticks != 0 || static_cast<double>(ticks) * tick_s > impl_->controlled_step_s * (1.0 + 1e-9))) {
      ticks /= 2;
    }
    const double step_s = static_cast<double>(ticks) * tick_s;
    before_K = impl_->temperatures_K;
    impl_->step(step_s);
    const double error_K = impl_->step_error_K(step_s);
    if (error_K > tolerance_K && ticks > 1) {
      impl_->temperatures_K = before_K;
      impl_->controlled_step_s = 0.5 * step_s;
      continue;
    }
    // The grid may have asked for a shorter step than the tolerance: that is no reason to forget the longer one.
    if (error_K < share_for_longer * tolerance_K)
      impl_->controlled_step_s = std::max(impl_->controlled_step_s, 2.0 * step_s);
    impl_->since_jump_s += step_s;
    at += ticks;
  }
}

const Eigen::VectorXd& FeStepper::temperatures_K() const { return impl_->temperatures_K; }

}  // namespace spindle_twin::fem_offline

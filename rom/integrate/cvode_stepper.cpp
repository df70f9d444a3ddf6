#include "rom/integrate/cvode_stepper.hpp"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "rom/integrate/newton_solver.hpp"
#include "rom/integrate/right_hand_side.hpp"

namespace spindle_twin::rom {
namespace {

/// What CVODE's calls are about.
struct Problem {
  RightHandSide* rhs;
  NewtonSolver* newton;
  /// Conductances of the K̃ that the solver has, none before the first.
  Eigen::VectorXd taken_W_per_m2K;
  /// 1 / capacity factor that it has, all 1 where there are none.
  Eigen::VectorXd taken_inverse_capacity;
  bool restarted;
  double tolerated_share;
};

int right_hand_side(realtype, N_Vector x, N_Vector dx, void* user_data) {
  static_cast<const Problem*>(user_data)->rhs->evaluate(NV_DATA_S(x), NV_DATA_S(dx));
  return 0;
}

bool jumped(const Eigen::VectorXd& before, const Eigen::VectorXd& now, double share) {
  for (Eigen::Index i = 0; i < now.size(); ++i) {
    if (std::abs(now[i] - before[i]) > share * std::max(std::abs(now[i]), std::abs(before[i]))) return true;
  }
  return false;
}

bool same_as(const Eigen::VectorXd& taken, const Eigen::VectorXd& wanted) {
  return wanted.size() == 0 ? (taken.array() == 1.0).all() : taken == wanted;
}

/// Empty stands for all `neutral`. `to` keeps its size.
void copy_or_fill(const Eigen::VectorXd& from, double neutral, Eigen::VectorXd& to) {
  if (from.size() > 0) {
    to = from;
  } else {
    to.setConstant(neutral);
  }
}

/// The same with `now` empty for all `neutral`.
bool jumped_from(const Eigen::VectorXd& before, const Eigen::VectorXd& now, double neutral, double share) {
  for (Eigen::Index i = 0; i < before.size(); ++i) {
    const double value = now.size() > 0 ? now[i] : neutral;
    if (std::abs(value - before[i]) > share * std::max(std::abs(value), std::abs(before[i]))) return true;
  }
  return false;
}

/// I − γ ∂f/∂x. Its K̃ may be one of some cycles ago.
// NOLINTNEXTLINE(readability-function-size): what CVODE calls
int newton_matrix(realtype, N_Vector x, N_Vector, SUNMatrix, booleantype serves, booleantype* fresh, realtype gamma,
                  void* user_data, N_Vector, N_Vector, N_Vector) {
  Problem& problem = *static_cast<Problem*>(user_data);
  const Eigen::VectorXd& wanted_W_per_m2K = problem.rhs->conductance_W_per_m2K();
  const Eigen::VectorXd& inverse_capacity = problem.rhs->inverse_capacity();
  const bool taken = problem.newton->decompositions() > 0;
  const double share = problem.tolerated_share;
  const bool near = problem.restarted && !jumped(problem.taken_W_per_m2K, wanted_W_per_m2K, share) &&
                    !jumped_from(problem.taken_inverse_capacity, inverse_capacity, 1.0, share);
  problem.restarted = false;
  const bool same =
      taken && problem.taken_W_per_m2K == wanted_W_per_m2K && same_as(problem.taken_inverse_capacity, inverse_capacity);
  const bool take = !taken || !(serves || near || same);
  if (take) {
    problem.newton->set_matrix(problem.rhs->lower(), problem.rhs->network().feedback_columns(), inverse_capacity);
    problem.taken_W_per_m2K = wanted_W_per_m2K;
    copy_or_fill(inverse_capacity, 1.0, problem.taken_inverse_capacity);
  }
  *fresh = take || same ? SUNTRUE : SUNFALSE;
  // A positive value tells CVODE to retry with a smaller step before it gives up.
  return problem.newton->set_step(gamma, problem.rhs->feedback(NV_DATA_S(x))) ? 0 : 1;
}

/// Failures come back as return values; CVODE's own text would go to stderr from inside the cycle.
void say_nothing(int, const char*, const char*, char*, void*) {}

/// Change of γ from which Newton's matrix is made anew.
constexpr double newest_gamma = 0.05;

struct Release {
  void operator()(_SUNContext* context) const { SUNContext_Free(&context); }
  void operator()(_generic_N_Vector* vector) const { N_VDestroy(vector); }
  void operator()(_generic_SUNMatrix* matrix) const { SUNMatDestroy(matrix); }
  void operator()(_generic_SUNLinearSolver* solver) const { SUNLinSolFree(solver); }
  void operator()(void* cvode) const { CVodeFree(&cvode); }
};

template <class T>
using Owned = std::unique_ptr<T, Release>;

template <class T>
Owned<T> own(T* made) {
  if (made == nullptr) throw std::runtime_error("CVODE cannot allocate its memory");
  return Owned<T>(made);
}

Owned<_SUNContext> make_context() {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  return own(context);
}

}  // namespace

struct CvodeStepper::Impl {  // NOLINT(public-members): private to this file; its order frees what CVODE holds
  Impl(std::shared_ptr<const NetworkOperator> network, const CvodeSettings& chosen);
  void check(int flag, const char* what) const {
    if (flag < 0) throw std::runtime_error(std::string("CVODE refuses ") + what);
  }
  bool restart();
  bool inputs_jumped(const BoundaryValues& values) const;
  bool node_heats_jumped(const BoundaryValues& values) const;
  StepStatus fail(StepStatus status);

  CvodeSettings settings;
  RightHandSide rhs;
  Eigen::VectorXd x;       // CVODE writes here
  Eigen::VectorXd x_good;  // at temperatures_K
  Eigen::VectorXd temperatures_K;
  Eigen::VectorXd candidate_K;
  BoundaryValues last;
  bool has_last = false;
  bool must_restart = true;
  double time_s = 0.0;
  long restarts = 0;
  // The counters of CVODE start at zero with every restart.
  CvodeCounts before_restart;
  int last_flag = 0;

  Owned<_SUNContext> context;
  Owned<_generic_N_Vector> state;
  std::optional<NewtonSolver> newton;
  Problem problem{};
  Owned<_generic_SUNMatrix> matrix;  // CVODE wants one; the numbers are in `newton`
  Owned<_generic_SUNLinearSolver> solver;
  Owned<void> cvode;
};

CvodeStepper::Impl::Impl(std::shared_ptr<const NetworkOperator> network, const CvodeSettings& chosen)
    : settings(chosen), rhs(std::move(network)) {
  const NetworkOperator& op = rhs.network();
  const Eigen::Index n = op.nodes();
  x = x_good = Eigen::VectorXd::Zero(n);
  temperatures_K = candidate_K = Eigen::VectorXd::Zero(n);
  op.to_temperatures(x, temperatures_K);
  last.conductance_W_per_m2K = Eigen::VectorXd::Zero(op.conductances());
  last.heat_W = Eigen::VectorXd::Zero(op.sources());
  last.environment_K = Eigen::VectorXd::Zero(op.environments());
  last.coolant_W_per_K = Eigen::VectorXd::Zero(op.circuits());
  last.node_heat_W = Eigen::VectorXd::Zero(n);
  rhs.hold(last);
  last.capacity_factor = Eigen::VectorXd::Ones(n);

  context = make_context();
  state = own(N_VMake_Serial(n, x.data(), context.get()));
  newton.emplace(n, op.feedback_columns().cols(), context.get());
  problem = {&rhs,
             &*newton,
             Eigen::VectorXd::Zero(op.conductances()),
             Eigen::VectorXd::Ones(n),
             true,
             settings.tolerated_share};
  matrix = own(SUNMatNewEmpty(context.get()));
  solver = own(view_for_sundials(*newton, context.get()));
  cvode = own(CVodeCreate(CV_BDF, context.get()));
  check(CVodeSetErrHandlerFn(cvode.get(), say_nothing, nullptr), "its error handler");
  check(CVodeInit(cvode.get(), right_hand_side, time_s, state.get()), "its start");
  check(CVodeSStolerances(cvode.get(), 0.0, settings.tolerance_K * op.internal_per_kelvin()), "its tolerance");
  check(CVodeSetUserData(cvode.get(), &problem), "its data");
  check(CVodeSetLinearSolver(cvode.get(), solver.get(), matrix.get()), "its linear solver");
  check(CVodeSetLinSysFn(cvode.get(), newton_matrix), "its Newton matrix");
  // The stop at every period's end makes steps of unequal length, and BDF of order 4 and 5 does not bear ratios much
  // beyond 1: its error then grows from step to step until the error control cuts the steps, which makes them unequal
  // again. With inputs held that could go on for ever, at two steps and two factors per cycle.
  check(CVodeSetMaxOrd(cvode.get(), 3), "its highest order");
  check(CVodeSetMaxNumSteps(cvode.get(), settings.max_internal_steps), "its bound on steps");
  // K̃ is the same from step to step, or nearly; a slow Newton asks for a new one by itself. Another γ costs next to
  // nothing, so CVODE need not live with an old one.
  check(CVodeSetLSetupFrequency(cvode.get(), 2000), "its bound on the age of a factor");
  check(CVodeSetJacEvalFrequency(cvode.get(), 2000), "its bound on the age of a Jacobian");
  check(CVodeSetDeltaGammaMaxLSetup(cvode.get(), newest_gamma), "its bound on the age of a step length");
}

bool CvodeStepper::Impl::restart() {
  long steps = 0, calls = 0;
  CVodeGetNumSteps(cvode.get(), &steps);
  CVodeGetNumRhsEvals(cvode.get(), &calls);
  time_s = 0.0;
  last_flag = CVodeReInit(cvode.get(), time_s, state.get());
  if (last_flag < 0) return false;
  before_restart.internal_steps += steps;
  before_restart.right_hand_sides += calls;
  ++restarts;
  problem.restarted = true;
  must_restart = false;
  return true;
}

bool CvodeStepper::Impl::inputs_jumped(const BoundaryValues& values) const {
  return !has_last || jumped(last.heat_W, values.heat_W, settings.jump_share) ||
         jumped(last.conductance_W_per_m2K, values.conductance_W_per_m2K, settings.jump_share) ||
         jumped(last.coolant_W_per_K, values.coolant_W_per_K, settings.jump_share) || node_heats_jumped(values) ||
         jumped_from(last.capacity_factor, values.capacity_factor, 1.0, settings.jump_share) ||
         (values.environment_K.size() > 0 &&
          (values.environment_K - last.environment_K).lpNorm<Eigen::Infinity>() > settings.jump_K);
}

/// By more than jump_share of the largest heat there is.
bool CvodeStepper::Impl::node_heats_jumped(const BoundaryValues& values) const {
  const auto largest = [](const Eigen::VectorXd& heat_W) {
    return heat_W.size() > 0 ? heat_W.lpNorm<Eigen::Infinity>() : 0.0;
  };
  double change_W = 0.0;
  for (Eigen::Index i = 0; i < last.node_heat_W.size(); ++i) {
    const double now_W = values.node_heat_W.size() > 0 ? values.node_heat_W[i] : 0.0;
    change_W = std::max(change_W, std::abs(now_W - last.node_heat_W[i]));
  }
  if (change_W == 0.0) return false;
  const double scale_W =
      std::max({largest(last.heat_W), largest(values.heat_W), largest(last.node_heat_W), largest(values.node_heat_W)});
  return change_W > settings.jump_share * scale_W;
}

StepStatus CvodeStepper::Impl::fail(StepStatus status) {
  x = x_good;
  must_restart = true;
  return status;
}

CvodeStepper::CvodeStepper(std::shared_ptr<const NetworkOperator> network, const CvodeSettings& settings)
    : impl_(std::make_unique<Impl>(std::move(network), settings)) {}

CvodeStepper::~CvodeStepper() = default;

void CvodeStepper::set_temperatures(const Eigen::VectorXd& temperatures_K) {
  impl_->temperatures_K = temperatures_K;
  impl_->rhs.network().to_internal(temperatures_K, impl_->x);
  impl_->x_good = impl_->x;
  impl_->must_restart = true;
}

StepStatus CvodeStepper::advance(double period_s, const BoundaryValues& values) {
  Impl& m = *impl_;
  if (!(period_s > 0.0) || !std::isfinite(period_s)) return StepStatus::integrator_failed;
  if (!all_finite(values) || !m.x.allFinite()) return StepStatus::not_finite;
  if (!accepts(m.rhs.network(), values)) return StepStatus::refused;

  if (m.inputs_jumped(values)) m.must_restart = true;
  m.rhs.follow(values, m.x.data());
  m.last.conductance_W_per_m2K = values.conductance_W_per_m2K;
  m.last.heat_W = values.heat_W;
  m.last.environment_K = values.environment_K;
  m.last.coolant_W_per_K = values.coolant_W_per_K;
  copy_or_fill(values.node_heat_W, 0.0, m.last.node_heat_W);
  copy_or_fill(values.capacity_factor, 1.0, m.last.capacity_factor);
  m.has_last = true;

  if (m.must_restart && !m.restart()) return m.fail(StepStatus::integrator_failed);
  const double end_s = m.time_s + period_s;
  m.last_flag = CVodeSetStopTime(m.cvode.get(), end_s);
  if (m.last_flag >= 0) m.last_flag = CVode(m.cvode.get(), end_s, m.state.get(), &m.time_s, CV_NORMAL);
  if (m.last_flag < 0) return m.fail(StepStatus::integrator_failed);
  m.rhs.network().to_temperatures(m.x, m.candidate_K);
  if (!m.candidate_K.allFinite()) return m.fail(StepStatus::not_finite);

  m.x_good = m.x;
  m.temperatures_K.swap(m.candidate_K);
  return StepStatus::ok;
}

const Eigen::VectorXd& CvodeStepper::temperatures_K() const { return impl_->temperatures_K; }

CvodeCounts CvodeStepper::counts() const {
  CvodeCounts counts = impl_->before_restart;
  long steps = 0, calls = 0;
  CVodeGetNumSteps(impl_->cvode.get(), &steps);
  CVodeGetNumRhsEvals(impl_->cvode.get(), &calls);
  counts.internal_steps += steps;
  counts.right_hand_sides += calls;
  counts.decompositions = impl_->newton->decompositions();
  counts.restarts = impl_->restarts;
  counts.last_flag = impl_->last_flag;
  return counts;
}

}  // namespace spindle_twin::rom

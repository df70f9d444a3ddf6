#include "firmware/cycle/remember.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "firmware/cycle/cycle.hpp"
#include "firmware/cycle/order_desk.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr double longest_step_s = 60.0;
constexpr double most_steps = 500.0;

void copy(const Eigen::VectorXd& from, std::vector<double>& to) {
  to.resize(static_cast<std::size_t>(from.size()));
  std::copy_n(from.data(), from.size(), to.begin());
}

std::string layout_of(const correction::EstimatorCorrection& estimator) {
  std::string layout;
  for (const correction::Parameter& parameter : estimator.parameters().list())
    layout.append(parameter.name).append(";");
  for (const correction::EstimatorSensor& sensor : estimator.sensors()) layout.append("|").append(sensor.name);
  if (const std::string origin = estimator.parameters().calibration_origin(); !origin.empty()) {
    layout.append("|calibration ").append(origin);
  }
  return layout;
}

// A spindle, what a reading may be taken as, and a growth, however warm it is.
constexpr double coldest_K = 173.15;
constexpr double hottest_K = 673.15;

bool is_within(const std::vector<double>& numbers, double least, double most) {
  return std::all_of(numbers.begin(), numbers.end(), [&](double number) { return number >= least && number <= most; });
}

/// Whatever its hash: a file that another program wrote, or that this one wrote when it was wrong.
bool is_plausible(const Remembered& from) {
  return is_within(from.nodes_K, coldest_K, hottest_K) && is_within(from.uncorrected_K, coldest_K, hottest_K) &&
         std::abs(from.tare_m) <= most_tare_m && from.model_time_s >= 0.0 && std::isfinite(from.model_time_s) &&
         is_within(from.sensor_tare.offset_K, -most_sensor_tare_K, most_sensor_tare_K);
}

bool fits(const std::vector<double>& numbers, Eigen::Index size) {
  return static_cast<Eigen::Index>(numbers.size()) == size &&
         std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

}  // namespace

std::optional<correction::KnownParameters> known_of_machine(const Remembered& from) {
  std::vector<std::string> names;
  std::istringstream lines(from.unknowns);
  for (std::string name; std::getline(lines, name);) names.push_back(name);
  return correction::known_from(std::move(names), from.estimator);
}

const correction::ParameterModel* Cycle::parameters() const {
  return corrector_.corrects && corrector_.estimator ? &corrector_.estimator->parameters() : nullptr;
}

void Cycle::remember(Remembered& to) const {
  to.started = started_;
  to.model_time_s = snapshot_.model_time_s;
  to.network_sha256 = network_sha256_;
  to.tare_m = snapshot_.tare_m + tare_to_come_m_;
  to.trial_away_m = compensation_.away_m();
  to.sensor_tare = watch_.tare;
  keep_health(watch_, to);
  to.signals = judgement_.signals;
  copy(model_.stepper->temperatures_K(), to.nodes_K);
  copy(uncorrected_.stepper->temperatures_K(), to.uncorrected_K);
  if (parameters() == nullptr) return;
  const correction::EstimatorCorrection& estimator = *corrector_.estimator;
  if (to.layout.empty()) {
    to.layout = layout_of(estimator);
    to.spindle = network_.spindle;
    to.calibration = estimator.parameters().calibration_origin();
    for (const std::string& name : estimator.unknowns()) to.unknowns.append(name).append(1, '\n');
  }
  estimator.save(to.estimator);
  to.parameters.resize(static_cast<std::size_t>(estimator.parameters().count()));
  for (std::size_t i = 0; i < to.parameters.size(); ++i) {
    to.parameters[i] = estimator.estimate(static_cast<Eigen::Index>(i));
  }
}

Resumed Cycle::resume(const Remembered& from, double gap_s, const std::atomic<bool>* stop) {
  const Eigen::Index nodes = start_K_.size();
  if (!from.started || !fits(from.nodes_K, nodes) || !fits(from.uncorrected_K, nodes) || !std::isfinite(from.tare_m) ||
      !(gap_s >= 0.0)) {
    return Resumed::nothing;
  }
  if (!is_plausible(from)) return Resumed::implausible;
  model_.stepper->set_temperatures(Eigen::Map<const Eigen::VectorXd>(from.nodes_K.data(), nodes));
  uncorrected_.stepper->set_temperatures(Eigen::Map<const Eigen::VectorXd>(from.uncorrected_K.data(), nodes));
  Judgement held = judgement_;
  held.signals = from.signals;
  held.signals[static_cast<std::size_t>(Signal::speed)] = 0.0;
  held.signals[static_cast<std::size_t>(Signal::load)] = 0.0;
  set_operating(network_, held, operating_);
  if (operating_.current_A) operating_.current_A = 0.0;
  if (operating_.power_W) operating_.power_W = 0.0;
  operating_.heat_W.setZero();

  bool known = false;
  if (corrector_.estimator) {
    const bool same = corrector_.corrects && from.layout == layout_of(*corrector_.estimator);
    if (!same) begin_with_machine(from);
    corrector_.estimator->reset(-gap_s, model_.stepper->temperatures_K(), operating_);
    known = same && corrector_.estimator->restore(from.estimator);
  }
  const auto tared = static_cast<Eigen::Index>(watch_.tare.offset_K.size());
  if (fits(from.sensor_tare.offset_K, tared) && fits(from.sensor_tare.deviation_K, tared)) {
    watch_.tare = from.sensor_tare;
  }
  resume_health(from, gap_s, watch_);
  const std::optional<Eigen::VectorXd> unseen_K = stand_still(gap_s, stop);
  if (!unseen_K) return Resumed::given_up;
  if (corrector_.estimator) corrector_.estimator->widen_start(0.0, model_.stepper->temperatures_K(), *unseen_K);
  if (corrector_.estimator) watch_anew(*corrector_.estimator, watch_);

  snapshot_.tare_m = from.tare_m;
  compensation_.resume_away(std::isfinite(from.trial_away_m) ? from.trial_away_m : 0.0);
  predict(network_, model_, expansion());
  publish_corrected(model_, 0.0, plan_.output_limit_m, snapshot_);
  started_ = true;
  return known ? Resumed::temperatures_and_estimator : Resumed::temperatures;
}

int Cycle::begin_with_machine(const Remembered& from) {
  if (parameters() == nullptr || from.spindle != network_.spindle) return 0;
  correction::EstimatorCorrection& estimator = *corrector_.estimator;
  // Another calibration is the newer knowledge, and one that is gone was revoked.
  if (from.calibration != estimator.parameters().calibration_origin()) return 0;
  std::optional<correction::KnownParameters> known = known_of_machine(from);
  if (!known) return 0;
  correction::add_drift(plan_.drift, *known);
  return estimator.begin_with(*known);
}

/// What the spindle would be warmer now if it had run at the operating state all the time.
std::optional<Eigen::VectorXd> Cycle::stand_still(double gap_s, const std::atomic<bool>* stop) {
  Model running = make_model(network_, [this](const rom::Network& of) {
    return shared_operator_ ? rom::make_runtime_stepper(shared_operator_) : rom::make_runtime_stepper(of);
  });
  running.stepper->set_temperatures(model_.stepper->temperatures_K());
  rom::OperatingState operating = operating_;
  operating.speed_rpm = network_.boundaries.operating.speed_rpm;
  operating.load = network_.boundaries.operating.load;
  operating.current_A.reset();
  operating.power_W.reset();
  operating.heat_W.setConstant(not_a_value);
  rom::CorrectionFactors described_heat = corrector_.none;
  const int steps = static_cast<int>(std::ceil(gap_s / std::max(longest_step_s, gap_s / most_steps)));
  rom::CorrectionFactors no_heat = corrector_.none;
  no_heat.heat.setZero();
  for (int step = 0; step < steps; ++step) {
    if (stop != nullptr && stop->load(std::memory_order_relaxed)) return std::nullopt;
    const double advance_s = gap_s / steps;
    const CorrectedInputs inputs =
        correct({}, judgement_, operating_, {-gap_s + step * advance_s, advance_s}, model_, corrector_);
    no_heat.conductance = described_heat.conductance = inputs.factors.conductance;
    operating.environment_K = inputs.operating.environment_K;
    integrate(network_, operating, described_heat, advance_s, running);
    integrate(network_, inputs.operating, no_heat, advance_s, model_);
    no_heat.conductance = corrector_.none.conductance;
    integrate(network_, operating_, no_heat, advance_s, uncorrected_);
  }
  return running.stepper->temperatures_K() - model_.stepper->temperatures_K();
}

}  // namespace spindle_twin::firmware

#include "correction/calibrate/predict_test.hpp"

#include <algorithm>
#include <cmath>

#include "correction/estimator/held_period.hpp"
#include "correction/estimator/sensitivities.hpp"
#include "correction/estimator/sensor_channel.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/read/input_error.hpp"

// Steps at each instant: sensors follow the model; a held period that is over is closed, which carries S on and turns
// what was gathered into readings; the model goes on with the factors of its temperatures.
namespace spindle_twin::correction {
namespace {

constexpr double instant_slack_s = 1e-6;

/// What a probe gathers in a held period.
struct ProbeChannel {
  Eigen::VectorXd internal;
  Eigen::VectorXd before;  // d(output)/dθ when the period began
  double residuals_m = 0.0;
  double readings_m = 0.0;
  int samples = 0;
};

/// Share of the way from a period's begin to its end at which the mean of n readings, evenly spread, lies.
double mean_share(int samples) { return (samples + 1.0) / (2.0 * samples); }

/// What is asked of one run.
struct AskedTest {
  const ThermalTest& test;
  const Eigen::VectorXd& theta;
  const Eigen::VectorXd& lag_s;
};

class TestRun {
 public:
  TestRun(const rom::Network& network, const CalibrateOptions& options,
          const std::shared_ptr<const rom::NetworkOperator>& coordinates, const ParameterModel& parameters,
          const AskedTest& asked)
      : network_(network),
        options_(options),
        parameters_(parameters),
        test_(asked.test),
        theta_(asked.theta),
        lag_s_(asked.lag_s),
        stepper_(rom::make_runtime_stepper(coordinates, settings_of(options))),
        sensitivities_(network, coordinates, parameters),
        period_(network, coordinates),
        factors_(parameters.make_factors(network)),
        values_(rom::make_boundary_values(network.boundaries)),
        bias_K_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.boundaries.environments.size()))),
        rises_K_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.boundaries.sources.size()))),
        place_(Eigen::VectorXd::Zero(parameters.count())) {
    start();
  }

  TestPrediction run() {
    const std::size_t instants = test_.time_s.size();
    for (std::size_t i = 0; i < instants; ++i) {
      look(i);
      if (i + 1 < instants) advance(test_.time_s[i], test_.time_s[i + 1], test_.operating[i]);
    }
    close(test_.time_s.back());
    return collect();
  }

 private:
  static rom::CvodeSettings settings_of(const CalibrateOptions& options) {
    rom::CvodeSettings settings;
    settings.tolerance_K = options.tolerance_K;
    return settings;
  }

  const Eigen::VectorXd& nodes_K() const { return stepper_->temperatures_K(); }

  void start() {
    Eigen::VectorXd start_K = Eigen::VectorXd::Constant(network_.capacity_J_per_K.rows(), test_.start_K);
    for (std::size_t k = 0; k < parameters_.shapes().size(); ++k) {
      start_K += theta_[parameters_.start() + static_cast<Eigen::Index>(k)] * parameters_.shapes()[k].rise_K;
    }
    stepper_->set_temperatures(start_K);
    sensitivities_.start(parameters_);
    Eigen::VectorXd internal = Eigen::VectorXd::Zero(start_K.size());
    for (const EstimatorSensor& sensor : options_.sensors) {
      sensitivities_.internal_row(sensor.row, internal);
      sensors_.emplace_back(internal, parameters_.count());
      sensors_.back().start(sensor.row.dot(start_K));
      sensitivities_.of_row(internal, place_);
      sensors_.back().set_sensitivity(place_);
    }
    for (const rom::DeformationOutput& output : network_.deformations) {
      sensitivities_.internal_row(output.row_m_per_K, internal);
      sensitivities_.of_row(internal, place_);
      probes_.push_back({internal, place_, 0.0, 0.0, 0});
    }
    due_s_.assign(sensors_.size() + probes_.size(), test_.time_s.front());
    seen_s_ = test_.time_s.front();
    set_factors(test_.operating.front().speed_rpm);
    open(seen_s_, test_.operating.front());
  }

  void set_factors(double speed_rpm) {
    sensitivities_.source_rises(nodes_K(), rises_K_);
    parameters_.apply(theta_, speed_rpm, rises_K_, factors_, bias_K_);
  }

  /// The model as the sensors see it at time_s.
  void follow(double time_s) {
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      sensors_[s].predict(options_.sensors[s].row.dot(nodes_K()), time_s - seen_s_,
                          lag_s_[static_cast<Eigen::Index>(s)]);
    }
    seen_s_ = time_s;
  }

  /// Takes the readings of instant i, and ends the held period where it is long enough or the inputs change.
  void look(std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double time_s = test_.time_s[i];
    follow(time_s);
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      sensors_[s].observe(test_.measured_K(row, static_cast<Eigen::Index>(s)));
    }
    for (std::size_t d = 0; d < probes_.size(); ++d) {
      const double reading_m = test_.deformation_m(row, static_cast<Eigen::Index>(d));
      if (!std::isfinite(reading_m)) continue;
      probes_[d].residuals_m += reading_m - deformation_m(d);
      probes_[d].readings_m += reading_m;
      ++probes_[d].samples;
    }
    if (time_s < period_.opened_s() + options_.held_s - instant_slack_s && !period_.differs(test_.operating[i])) return;
    close(time_s);
    set_factors(test_.operating[i].speed_rpm);
    open(time_s, test_.operating[i]);
  }

  double deformation_m(std::size_t d) const {
    const Eigen::VectorXd& row = network_.deformations[d].row_m_per_K;
    return row.dot(nodes_K()) - row.sum() * network_.boundaries.reference_temperature_K;
  }

  void open(double time_s, const rom::OperatingState& operating) {
    period_.open(time_s, nodes_K(), operating, factors_, bias_K_);
    for (SensorChannel& sensor : sensors_) {
      sensor.clear();
      sensitivities_.of_row(sensor.internal(), place_);
      sensor.begin_period(place_);
    }
    for (ProbeChannel& probe : probes_) {
      sensitivities_.of_row(probe.internal, probe.before);
      probe.residuals_m = probe.readings_m = 0.0;
      probe.samples = 0;
    }
  }

  void close(double time_s) {
    if (!period_.is_open()) return;
    const double period_s = period_.close(time_s, nodes_K(), theta_, parameters_, sensitivities_);
    if (period_s < 0.0) fail(time_s);
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      const Eigen::VectorXd before = sensors_[s].sensitivity();
      sensitivities_.of_row(sensors_[s].internal(), place_);
      sensors_[s].end_period(place_, period_s, lag_s_[static_cast<Eigen::Index>(s)]);
      note_sensor(time_s, s, before);
    }
    for (std::size_t d = 0; d < probes_.size(); ++d) note_probe(time_s, d);
  }

  bool is_due(double time_s, std::size_t channel) {
    if (time_s < due_s_[channel] - instant_slack_s) return false;
    due_s_[channel] = time_s + options_.interval_s;
    return true;
  }

  void note_sensor(double time_s, std::size_t s, const Eigen::VectorXd& before) {
    const SensorChannel& sensor = sensors_[s];
    if (sensor.samples() == 0 || !is_due(time_s, s)) return;
    const double share = mean_share(sensor.samples());
    found_.push_back({time_s, static_cast<int>(s), sensor.mean_residual_K(), sensor.mean_reading_K() - test_.start_K,
                      sensor.samples(), sensor.mean_lag_slope(), sensor.mean_reading_K()});
    rows_.push_back(before + share * (sensor.sensitivity() - before));
  }

  void note_probe(double time_s, std::size_t d) {
    const ProbeChannel& probe = probes_[d];
    const std::size_t channel = sensors_.size() + d;
    if (probe.samples == 0 || !is_due(time_s, channel)) return;
    const double share = mean_share(probe.samples);
    sensitivities_.of_row(probe.internal, place_);
    found_.push_back({time_s, static_cast<int>(channel), probe.residuals_m / probe.samples, 0.0, probe.samples, 0.0,
                      probe.readings_m / probe.samples});
    rows_.push_back(probe.before + share * (place_ - probe.before));
  }

  /// In pieces of at most held_s, each with the friction of its first temperatures.
  void advance(double from_s, double to_s, const rom::OperatingState& operating) {
    const auto pieces = std::max(1L, std::lround(std::ceil((to_s - from_s) / options_.held_s - instant_slack_s)));
    const double piece_s = (to_s - from_s) / static_cast<double>(pieces);
    for (long piece = 0; piece < pieces; ++piece) {
      if (piece > 0) {
        const double now_s = from_s + static_cast<double>(piece) * piece_s;
        follow(now_s);
        close(now_s);
        set_factors(operating.speed_rpm);
        open(now_s, operating);
      } else {
        set_factors(operating.speed_rpm);
      }
      rom::OperatingState corrected = operating;
      corrected.environment_K += bias_K_;
      rom::evaluate_boundaries(network_.boundaries, corrected, factors_, values_);
      if (stepper_->advance(piece_s, values_) != rom::StepStatus::ok) fail(from_s);
    }
  }

  TestPrediction collect() {
    TestPrediction result;
    result.readings = std::move(found_);
    result.sensitivities.resize(static_cast<Eigen::Index>(rows_.size()), parameters_.count());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      result.sensitivities.row(static_cast<Eigen::Index>(i)) = rows_[i].transpose();
    }
    if (!probes_.empty()) {
      sensitivities_.of_row(probes_.front().internal, place_);
      result.last_output = place_;
    }
    return result;
  }

  [[noreturn]] void fail(double time_s) const {
    throw rom::InputError({test_.name, 0}, "time_s",
                          "the model cannot be integrated with these parameters at " + std::to_string(time_s) + " s");
  }

  const rom::Network& network_;
  const CalibrateOptions& options_;
  const ParameterModel& parameters_;
  const ThermalTest& test_;
  const Eigen::VectorXd& theta_;
  const Eigen::VectorXd& lag_s_;
  std::unique_ptr<rom::FallbackStepper> stepper_;
  Sensitivities sensitivities_;
  HeldPeriod period_;
  rom::CorrectionFactors factors_;
  rom::BoundaryValues values_;
  Eigen::VectorXd bias_K_, rises_K_, place_;
  std::vector<SensorChannel> sensors_;
  std::vector<ProbeChannel> probes_;
  std::vector<double> due_s_;
  double seen_s_ = 0.0;
  std::vector<TestReading> found_;
  std::vector<Eigen::VectorXd> rows_;
};

}  // namespace

TestPredictor::TestPredictor(const rom::Network& network, const CalibrateOptions& options)
    : network_(&network),
      options_(&options),
      coordinates_(std::make_shared<const rom::NetworkOperator>(network)),
      parameters_(network, options.priors) {}

TestPrediction TestPredictor::predict(const ThermalTest& test, const Eigen::VectorXd& theta,
                                      const Eigen::VectorXd& lag_s) const {
  return TestRun(*network_, *options_, coordinates_, parameters_, {test, theta, lag_s}).run();
}

}  // namespace spindle_twin::correction

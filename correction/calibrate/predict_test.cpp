#include "correction/calibrate/predict_test.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "correction/calibrate/stepped_state.hpp"
#include "correction/calibrate/test_steps.hpp"
#include "correction/estimator/inputs_changed.hpp"
#include "correction/estimator/sensor_channel.hpp"
#include "rom/read/input_error.hpp"

// The state goes from step to step; between their ends its places lie on a straight line, on which sensors follow them
// from instant to instant and readings are gathered, values and derivatives alike.
namespace spindle_twin::correction {
namespace {

/// Places of all channels: sensors in K, outputs in m.
struct Places {
  Eigen::VectorXd value;
  Eigen::MatrixXd slope;  // p x channels, d(value)/dθ
};

/// What was gathered of one channel since its period began.
struct Gathered {
  double residuals = 0.0, readings = 0.0, lag_slopes = 0.0;
  Eigen::VectorXd slopes;
  int samples = 0;
};

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
      : options_(options),
        test_(asked.test),
        theta_(asked.theta),
        lag_s_(asked.lag_s),
        sensors_(static_cast<Eigen::Index>(options.sensors.size())),
        channels_(sensors_ + static_cast<Eigen::Index>(network.deformations.size())),
        model_(parameters),
        parameters_(parameters.count()),
        state_(network, coordinates, parameters, asked.theta) {
    const double reference_K = network.boundaries.reference_temperature_K;
    rows_.resize(coordinates->nodes(), channels_);
    at_reference_ = Eigen::VectorXd::Zero(channels_);
    for (Eigen::Index s = 0; s < sensors_; ++s) {
      const Eigen::VectorXd& row = options.sensors[static_cast<std::size_t>(s)].row;
      rows_.col(s) = state_.internal_row(row);
      at_reference_[s] = row.sum() * reference_K;
    }
    for (Eigen::Index d = sensors_; d < channels_; ++d) {
      rows_.col(d) = state_.internal_row(network.deformations[static_cast<std::size_t>(d - sensors_)].row_m_per_K);
    }
  }

  TestPrediction run() {
    start();
    std::size_t instant = 0;
    look(instant++);
    for (const TestStep& step : test_steps(test_, options_.longest_step_s)) {
      if (!state_.advance(step.end_s - step.begin_s, step.operating)) fail(step.begin_s);
      std::swap(before_, after_);
      see(after_);
      begin_s_ = step.begin_s;
      end_s_ = step.end_s;
      while (instant < test_.time_s.size() && test_.time_s[instant] <= step.end_s + instant_slack_s) {
        follow(std::min(test_.time_s[instant], step.end_s));
        look(instant++);
      }
      follow(step.end_s);
    }
    close(test_.time_s.back());
    return collect();
  }

 private:
  void start() {
    state_.start(test_.start_K);
    see(after_);
    before_ = now_ = shown_ = after_;
    lag_slopes_ = Eigen::VectorXd::Zero(sensors_);
    begin_s_ = end_s_ = seen_s_ = test_.time_s.front();
    due_s_.assign(static_cast<std::size_t>(channels_), seen_s_);
    gathered_.resize(static_cast<std::size_t>(channels_));
    open(0);
  }

  void see(Places& places) const {
    places.value = at_reference_;
    places.value.noalias() += rows_.transpose() * state_.x();
    places.slope.noalias() = state_.sensitivities().transpose() * rows_;
    for (Eigen::Index d = sensors_; d < channels_; ++d) model_.expand(theta_, places.value[d], places.slope.col(d));
  }

  /// Places at time_s, and what sensors show of them.
  void follow(double time_s) {
    const double period_s = time_s - seen_s_;
    if (period_s <= 0.0) return;
    const Places from = now_;
    const double share = (time_s - begin_s_) / (end_s_ - begin_s_);
    now_.value = before_.value + share * (after_.value - before_.value);
    now_.slope = before_.slope + share * (after_.slope - before_.slope);
    for (Eigen::Index s = 0; s < sensors_; ++s) {
      const double lag_s = lag_s_[s];
      lag_slopes_[s] = lag_slope(lag_slopes_[s], shown_.value[s], from.value[s], now_.value[s], period_s, lag_s);
      shown_.value[s] = lag(shown_.value[s], from.value[s], now_.value[s], period_s, lag_s);
      shown_.slope.col(s) = lag(1.0, 0.0, 0.0, period_s, lag_s) * shown_.slope.col(s) +
                            lag(0.0, 1.0, 0.0, period_s, lag_s) * from.slope.col(s) +
                            lag(0.0, 0.0, 1.0, period_s, lag_s) * now_.slope.col(s);
    }
    const Eigen::Index outputs = channels_ - sensors_;
    shown_.value.tail(outputs) = now_.value.tail(outputs);
    shown_.slope.rightCols(outputs) = now_.slope.rightCols(outputs);
    seen_s_ = time_s;
  }

  void open(std::size_t instant) {
    opened_ = instant;
    for (Gathered& gathered : gathered_) gathered = {0.0, 0.0, 0.0, Eigen::VectorXd::Zero(parameters_), 0};
  }

  /// Takes the readings of an instant, and ends the period where it is long enough or the inputs change.
  void look(std::size_t instant) {
    const auto row = static_cast<Eigen::Index>(instant);
    for (Eigen::Index c = 0; c < channels_; ++c) {
      const double reading = c < sensors_ ? test_.measured_K(row, c) : test_.deformation_m(row, c - sensors_);
      if (!std::isfinite(reading)) continue;
      Gathered& gathered = gathered_[static_cast<std::size_t>(c)];
      gathered.readings += reading;
      gathered.residuals += reading - shown_.value[c];
      gathered.slopes += shown_.slope.col(c);
      if (c < sensors_) gathered.lag_slopes += lag_slopes_[c];
      ++gathered.samples;
    }
    const double time_s = test_.time_s[instant];
    const bool is_over = time_s >= test_.time_s[opened_] + options_.held_s - instant_slack_s;
    if (!is_over && !inputs_changed(test_.operating[instant], test_.operating[opened_])) return;
    close(time_s);
    open(instant);
  }

  void close(double time_s) {
    for (Eigen::Index c = 0; c < channels_; ++c) {
      const Gathered& gathered = gathered_[static_cast<std::size_t>(c)];
      double& due_s = due_s_[static_cast<std::size_t>(c)];
      if (gathered.samples == 0 || time_s < due_s - instant_slack_s) continue;
      due_s = time_s + options_.interval_s;
      const double count = gathered.samples, mean = gathered.readings / count;
      found_.push_back({time_s, static_cast<int>(c), gathered.residuals / count,
                        c < sensors_ ? mean - test_.start_K : 0.0, gathered.samples, gathered.lag_slopes / count,
                        mean});
      slopes_.push_back(gathered.slopes / count);
    }
  }

  TestPrediction collect() {
    TestPrediction result;
    result.readings = std::move(found_);
    result.sensitivities.resize(static_cast<Eigen::Index>(slopes_.size()), parameters_);
    for (std::size_t i = 0; i < slopes_.size(); ++i) {
      result.sensitivities.row(static_cast<Eigen::Index>(i)) = slopes_[i].transpose();
    }
    if (channels_ > sensors_) result.last_output = after_.slope.col(sensors_);
    return result;
  }

  [[noreturn]] void fail(double time_s) const {
    throw rom::InputError({test_.name, 0}, "time_s",
                          "the model cannot be integrated with these parameters at " + std::to_string(time_s) + " s");
  }

  const CalibrateOptions& options_;
  const ThermalTest& test_;
  const Eigen::VectorXd& theta_;
  const Eigen::VectorXd& lag_s_;
  Eigen::Index sensors_, channels_;
  const ParameterModel& model_;
  Eigen::Index parameters_;
  SteppedState state_;
  Eigen::MatrixXd rows_;          // of the places on x, N x channels
  Eigen::VectorXd at_reference_;  // what they are at the reference temperature
  Places before_, after_;         // at the ends of the present step
  double begin_s_ = 0.0, end_s_ = 0.0;
  Places now_, shown_;  // at seen_s_, and what the channels show of it
  double seen_s_ = 0.0;
  Eigen::VectorXd lag_slopes_;  // d(shown)/dτ
  std::size_t opened_ = 0;
  std::vector<Gathered> gathered_;
  std::vector<double> due_s_;
  std::vector<TestReading> found_;
  std::vector<Eigen::VectorXd> slopes_;
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

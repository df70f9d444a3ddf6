#include "tests/bench/faults/follow.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "firmware/cycle/cycle.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/units.hpp"
#include "tests/bench/reality/default_plan.hpp"

namespace spindle_twin::bench {
namespace {

constexpr double noise_K = 0.03;
constexpr double offset_K = 0.02;
constexpr double moving_K = 0.25;
constexpr double moving_window_s = 120.0;

/// Truth at any instant, and what its sensors say.
struct Sensors {
  Sensors(const Truth& the_truth, double the_resolution_K)
      : truth(the_truth), random(the_truth.seed), resolution_K(the_resolution_K) {
    offsets_K = Eigen::VectorXd::Zero(truth.key_points_K.cols());
    for (double& offset : offsets_K) offset = offset_K * normal(random);
    readings_K = offsets_K;
  }
  void read(double time_s) {
    const auto k = static_cast<Eigen::Index>(time_s / sample_s);
    const double share = time_s / sample_s - static_cast<double>(k);
    const Eigen::Index next = std::min(k + 1, truth.nose_m.size() - 1);
    for (Eigen::Index s = 0; s < readings_K.size(); ++s) {
      const double true_K = (1.0 - share) * truth.key_points_K(k, s) + share * truth.key_points_K(next, s);
      readings_K[s] = true_K + offsets_K[s] + noise_K * normal(random);
    }
  }
  /// The truth changes by a quarter of a kelvin within the next two minutes.
  bool moves(double time_s, int sensor) const {
    const auto k = static_cast<Eigen::Index>(time_s / sample_s);
    const auto count = std::min<Eigen::Index>(std::lround(moving_window_s / sample_s) + 1, truth.nose_m.size() - k);
    const auto ahead = truth.key_points_K.col(sensor).segment(k, count);
    return count > 1 && ahead.maxCoeff() - ahead.minCoeff() >= moving_K;
  }
  void quantise() {
    for (double& reading_K : readings_K) reading_K = resolution_K * std::round(reading_K / resolution_K);
  }
  const Truth& truth;
  std::mt19937_64 random;
  std::normal_distribution<double> normal{0.0, 1.0};
  double resolution_K;
  Eigen::VectorXd offsets_K, readings_K;
};

double nose_m(const Truth& truth, double time_s) {
  const auto k = std::min(static_cast<Eigen::Index>(time_s / sample_s), truth.nose_m.size() - 2);
  const double share = time_s / sample_s - static_cast<double>(k);
  return (1.0 - share) * truth.nose_m[k] + share * truth.nose_m[k + 1];
}

/// What the PLC says of the machine.
void tell(const rom::Boundaries& boundaries, const rom::OperatingState& operating, double time_s,
          firmware::PlcCommand& command) {
  const auto set = [&](firmware::Signal signal, double value) {
    command.signals[static_cast<std::size_t>(signal)] = {value, clock_ns(time_s)};
  };
  set(firmware::Signal::speed, operating.speed_rpm);
  set(firmware::Signal::load, operating.load);
  set(firmware::Signal::coolant,
      rom::first_environment_K(boundaries, rom::EnvironmentKind::coolant, operating).value());
  set(firmware::Signal::ambient,
      rom::first_environment_K(boundaries, rom::EnvironmentKind::ambient, operating).value());
}

/// Sums on their way to a result.
class Judge {
 public:
  Judge(const Fault& fault, const Sensors& readings, double cycle_s)
      : readings_(readings), cycle_s_(cycle_s), was_out_(static_cast<std::size_t>(readings.offsets_K.size()), false) {
    result_.fault = fault;
  }

  /// What was published at time_s, for the end of the period.
  void note(const firmware::Snapshot& now, double time_s) {
    for (std::size_t s = 0; s < was_out_.size(); ++s) note_sensor(now, time_s, s);
    const Fault& fault = result_.fault;
    if (is_active(fault.sensor, time_s) && result_.moving_s < 0.0 && readings_.moves(time_s, fault.sensor)) {
      result_.moving_s = time_s - fault.from_s;
    }
    note_nose(now, time_s);
  }

  Followed result() const {
    Followed result = result_;
    result.error_um = std::sqrt(result.error_um / static_cast<double>(judged_));
    result.deviation_um = std::sqrt(result.deviation_um / static_cast<double>(judged_));
    if (before_found_ > 0) {
      result.inside_until_found = static_cast<double>(inside_) / static_cast<double>(before_found_);
    }
    return result;
  }

 private:
  bool is_active(int sensor, double time_s) const {
    const Fault& fault = result_.fault;
    return !fault.is_reference() && fault.concerns(sensor) && time_s >= fault.from_s;
  }

  void note_sensor(const firmware::Snapshot& now, double time_s, std::size_t s) {
    const Fault& fault = result_.fault;
    const auto sensor = static_cast<int>(s);
    const bool active = is_active(sensor, time_s), first = active && sensor == fault.sensor;
    const bool withdrawn = fault.is_reference() && fault.concerns(sensor);
    const firmware::SensorState state = now.sensor_health[s].state;
    // An input that reads open while its sensor is unplugged is no fault of the sensor.
    const bool plug = fault.unplugged.reads_open && now.sensor_health[s].fault == firmware::SensorFault::open;
    const bool out = !plug && (state == firmware::SensorState::failed || state == firmware::SensorState::returning);
    const bool usable = now.sensor_quality[s] == firmware::SensorQuality::good;
    const bool fell = out && !was_out_[s];
    if (fell && first && result_.delay_s < 0.0) {
      result_.delay_s = time_s - fault.from_s;
      result_.named = now.sensor_health[s].fault;
    }
    if (first && result_.withheld_s < 0.0 && !usable) result_.withheld_s = time_s - fault.from_s;
    if (fell && !active && !withdrawn) ++result_.false_alarms;
    if (!active && !withdrawn && !usable) ++result_.withheld;
    if (first && time_s >= fault.until_s && was_out_[s] && !out) {
      result_.returned_s = time_s - fault.until_s;
    }
    was_out_[s] = out;
  }

  void note_nose(const firmware::Snapshot& now, double time_s) {
    const double nose_um = rom::um_per_m * now.nose_m, raw_um = rom::um_per_m * now.deformation_raw_m[0];
    const double from_s = std::max(result_.fault.from_s, judged_from_s);
    if (time_s >= from_s) {
      const double error_um = nose_um - rom::um_per_m * nose_m(readings_.truth, time_s + cycle_s_);
      const double deviation_um = rom::um_per_m * now.deformation_deviation_m[0];
      result_.error_um += error_um * error_um;
      result_.deviation_um += deviation_um * deviation_um;
      result_.largest_um = std::max(result_.largest_um, std::abs(error_um));
      result_.raw_step_um = std::max(result_.raw_step_um, std::abs(raw_um - raw_um_));
      result_.step_um = std::max(result_.step_um, std::abs(nose_um - nose_um_));
      ++judged_;
      if (result_.delay_s < 0.0) {
        ++before_found_;
        inside_ += std::abs(error_um) <= 2.0 * deviation_um ? 1 : 0;
        result_.largest_until_found = std::max(result_.largest_until_found, std::abs(error_um) / deviation_um);
      }
    }
    nose_um_ = nose_um;
    raw_um_ = raw_um;
  }

  const Sensors& readings_;
  double cycle_s_;
  Followed result_;
  std::vector<bool> was_out_;
  double nose_um_ = 0.0, raw_um_ = 0.0;
  long judged_ = 0, before_found_ = 0, inside_ = 0;
};

}  // namespace

Followed follow(const rom::Network& network, const Truth& truth, const Fault& fault, const FollowOptions& options) {
  Sensors readings(truth, options.resolution_K);
  const auto sensors = static_cast<std::size_t>(readings.readings_K.size());
  firmware::CyclePlan plan = default_plan(sensors, options.cycle_s);
  plan.estimator->priors = options.priors;
  if (!options.with_health) plan.health.reset();
  std::optional<firmware::Cycle> cycle;
  const auto start = [&] {
    cycle.emplace(network, plan, [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
  };
  start();
  Saboteur saboteur(fault, truth.seed);
  Judge judge(fault, readings, options.cycle_s);
  firmware::DeviceFrame frame;
  firmware::PlcCommand command;
  frame.connected = true;
  const long cycles = std::lround(run_s / options.cycle_s);
  for (long k = 0; k < cycles; ++k) {
    const double time_s = static_cast<double>(k) * options.cycle_s;
    tell(network.boundaries, truth.read[static_cast<std::size_t>(time_s / sample_s)], time_s, command);
    readings.read(time_s);
    readings.quantise();
    saboteur.tamper(time_s, readings.readings_K);
    if (fault.is_daemon_off(time_s)) continue;
    if (k > 0 && fault.is_daemon_off(static_cast<double>(k - 1) * options.cycle_s)) {
      firmware::Remembered remembered;
      cycle->remember(remembered);
      start();
      cycle->resume(remembered, fault.unplugged.for_s);
    }
    for (std::size_t s = 0; s < sensors; ++s) {
      const bool withdrawn = fault.is_reference() && fault.concerns(static_cast<int>(s)) && fault.at(time_s);
      frame.sensors[s] = {withdrawn ? firmware::not_a_value : readings.readings_K[static_cast<Eigen::Index>(s)],
                          clock_ns(time_s)};
    }
    judge.note(cycle->step(frame, command, clock_ns(time_s), 0), time_s);
  }
  return judge.result();
}

}  // namespace spindle_twin::bench

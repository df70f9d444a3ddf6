#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "firmware/config/config.hpp"
#include "firmware/show/shown_spindle.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/support/recorded.hpp"
#include "tests/support/text_faults.hpp"

/// What the daemon says to each mistake in a configuration, and what it makes of each value, as it was when this was
/// recorded.
namespace spindle_twin::firmware {
namespace config_recorded_refusals_test {

constexpr tests::Tolerance tolerance{1e-11};

/// Every table there is.
const char* const tables = R"(log_level = "info"
[network]
file = "x.rom"
allow_uncertified = true
require_signature = false
[cycle]
period_s = 1.0
clock_rate = 2.0
compare_uncorrected = true
[serve]
address = "127.0.0.1"
port = 1502
allow = ["127.0.0.0/8"]
allow_write = ["127.0.0.1"]
connections = 8
connections_per_host = 4
idle_s = 60.0
frame_deadline_s = 1.0
plc_timeout_s = 8.0
[http]
address = "127.0.0.1"
port = 9502
allow = ["127.0.0.0/8"]
names = ["twin.local"]
[[device]]
name = "cabinet"
driver = "modbus"
address = "127.0.0.1"
port = 1503
unit = 1
timeout_s = 0.5
poll_s = 1.0
delay_s = 0.25
retry_s = 0.1
retry_most_s = 5.0
[[device]]
name = "node"
driver = "stream"
address = "127.0.0.1"
port = 1504
allow = ["127.0.0.0/8"]
connections = 4
idle_s = 10.0
frame_deadline_s = 1.0
[[device]]
name = "module"
preset = "moxa_e1260"
[[sensor]]
key_point = "point 0"
device = "cabinet"
register = 0
table = "input"
type = "int16"
scale = 0.1
offset = 0.5
conversion = "pt100"
mean_s = 2.0
min_degC = -10.0
max_degC = 120.0
stale_after_s = 5.0
resolution_K = 0.1
interval_s = 2.0
noise_K = 0.04
offset_K = 0.05
lag_s = 3.0
[[sensor]]
key_point = "point 1"
device = "node"
channel = 7
low_pass_s = 1.5
[[sensor]]
key_point = "point 2"
device = "module"
channel = 2
[[displacement]]
output = "nose"
device = "cabinet"
register = 10
type = "float32_cdab"
sd_um = 1.0
interval_s = 60.0
min_um = -500.0
max_um = 600.0
stale_after_s = 4.0
[signals]
speed = { source = "plc", first = 0.0, max = 20000.0, max_per_s = 4000.0 }
load = { source = "plc", stale_after_s = 0.0, min = -0.5 }
coolant = { source = "device", device = "cabinet", register = 6, type = "float32", first = 20.0 }
ambient = { source = "constant", value = 22.0 }
current = { source = "device", device = "cabinet", register = 9, type = "int16", scale = 0.01 }
power = { source = "device", device = "node", channel = 10, mean_s = 1.0 }
flow.helix = { source = "device", device = "cabinet", register = 8, scale = 0.001, conversion = "4-20mA", at_4mA = 0.0, at_20mA = 0.5 }
[correction]
law = "estimator"
enabled = true
period_s = 10.0
noise_K = 0.03
floor_K = 0.03
gate = 5.0
offset_K = 0.02
lag_s = 0.0
lag_deviation_s = 14.0
floor_by_hand_K = 0.3
floor_largest_K = 1.0
curvature = 0.5
correlation_s = 60.0
offset_walk_K_per_root_hour = 0.002
second_pass = 20.0
[correction.prior]
heat = 0.4
contact = 0.5
centred = true
heat_common = 0.0
friction_common = 0.0
heat_by_current = 0.0
fit_common = 0.0
film = 0.3
environment_K = 0.1
environment_memory_s = 1800.0
bearing_mean_per_K = 0.010
bearing_per_K = 0.005
speed_exponent = 0.15
expansion = 0.05
start_K = 0.2
start_shape_K = 0.05
disturbance = 0.01
disturbance_by_hand = 0.1
disturbance_memory_s = 3600.0
capacity = 0.3
heat_walk_per_root_min = 0.003
contact_walk_per_root_min = 0.005
film_walk_per_root_min = 0.003
[health]
enabled = true
open_above_degC = 300.0
jump_K = 0.3
spikes = 4
short_below_degC = -100.0
jump_share = 1.0
spike_window_s = 600.0
stuck_K = 0.1
stuck_window_s = 120.0
drift_limit = 30.0
drift_lead = 8.0
rejected = 2
swap_K = 0.1
swap_limit = 30.0
return_after_s = 300.0
return_offset_K = 0.2
return_within_K = 0.5
failures = 3
[health.tare]
rest_s = 3600.0
block_s = 300.0
rate_K_per_h = 0.3
spread_K = 1.0
model_spread_K = 0.05
reference = "ambient"
[output]
slew_um_per_s = 0.5
limit_um = { nose = 80.0 }
[compensation]
enabled = true
sign = -1
slew_um_per_s = 0.2
step_um = 0.5
limit_um = 60.0
warning_um = 50.0
on_loss = "hold"
hold_min = 5.0
decay_min = 20.0
look_ahead_min = 15.0
settled_um = 2.0
reference_mm = 10.0
other = "rings apart"
distance_mm = -200.0
[start]
temperature_degC = 21.0
wait_s = 30.0
[history]
path = "history.sqlite"
most_MiB = 512.0
most_days = 30.0
parameters = "parameters.csv"
[orders]
path = "twin.orders"
[checkpoint]
path = "twin.checkpoint"
interval_s = 120.0
max_age_h = 6.0
[plant]
host = "broker"
port = 1883
group = "hall"
node = "mill"
period_s = 10.0
queue = 360
registers = ["nose", "state"]
)";

/// A sum to which each of these adds its logarithm.
class Sum {
 public:
  template <class... Numbers>
  Sum& operator()(Numbers... numbers) {
    (add(static_cast<double>(numbers)), ...);
    return *this;
  }
  Sum& operator()(const std::string& text) {
    for (const char c : text) add(static_cast<double>(c));
    return *this;
  }
  double value() const { return sum_; }

 private:
  void add(double number) {
    ++count_;
    constexpr double smallest = 1e-9;
    if (std::isfinite(number)) {
      sum_ += (1.0 + 0.01 * count_) * std::copysign(std::log1p(std::min(std::abs(number), 1e200) / smallest), number);
    }
  }
  double sum_ = 0.0;
  int count_ = 0;
};

double sum_of_cycle(const CyclePlan& plan) {
  Sum sum;
  sum(plan.period_s, plan.clock_rate, plan.compare_uncorrected, plan.correction_enabled, plan.estimator.has_value(),
      plan.paper.has_value(), plan.estimator_corrects, plan.health.has_value(), plan.tare_to_ambient,
      plan.plc_timeout_s, plan.slew_m_per_s, plan.start_wait_s, plan.start_temperature_K.value_or(0.0));
  for (const SensorPlan& sensor : plan.sensors) {
    sum(sensor.configured, sensor.min_K, sensor.max_K, sensor.stale_after_s, sensor.noise_K, sensor.offset_deviation_K,
        sensor.lag_s, sensor.interval_s, sensor.resolution_K);
  }
  for (const ProbePlan& probe : plan.probes) {
    sum(probe.configured, 1e6 * probe.deviation_m, 1e6 * probe.min_m, 1e6 * probe.max_m, probe.interval_s,
        probe.stale_after_s);
  }
  for (const SignalPlan& signal : plan.signals) {
    sum(static_cast<int>(signal.source), signal.value, signal.min, signal.max, signal.stale_after_s, signal.most_per_s);
  }
  for (const double limit_m : plan.output_limit_m) sum(1e6 * limit_m);
  const CompensationPlan& compensation = plan.compensation;
  sum(compensation.enabled, compensation.sign, 1e6 * compensation.slew_m_per_s, 1e6 * compensation.step_m,
      1e6 * compensation.warning_m, 1e6 * compensation.limit_m, static_cast<int>(compensation.on_loss),
      compensation.hold_s, compensation.decay_s, compensation.other, compensation.distance_m, compensation.reference_m,
      plan.forecast.ahead_s, 1e6 * plan.forecast.settled_m, plan.forecast.every_cycles);
  const auto add = [&](const rom::Option&, auto value) { sum(value); };
  if (plan.estimator) correction::EstimatorOptions::each(*plan.estimator, add);
  if (plan.health) correction::HealthLimits::each(*plan.health, add);
  correction::TareLimits::each(plan.tare, add);
  return sum.value();
}

double sum_of_rest(const SpindlePlan& plan, const Config& config) {
  Sum sum;
  const ServePlan& serve = config.serve;
  sum(serve.address)(serve.port, serve.allow.size(), serve.write.size(), serve.connections, serve.connections_per_host,
                     serve.idle_s, serve.frame_deadline_s);
  const ShowPlan& show = config.show;
  sum(show.address)(show.enabled, show.port, show.allow.size(), show.names.size(),
                    stale_after_s(plan.cycle.period_s / plan.cycle.clock_rate));
  sum(config.history.path)(config.history.segment_bytes, config.history.most_bytes, config.history.most_days);
  sum(config.keep.checkpoint_path)(config.keep.interval_s, config.keep.max_age_s)(config.keep.parameters_path);
  sum(config.keep.orders_path)(config.log_level)(config.network.path);
  sum(config.network.allow_uncertified, config.network.require_signature, config.network.trusted_keys.size());
  for (const DevicePlan& device : plan.devices) {
    sum(device.name)(device.poll_s, device.delay_s, device.retry_s, device.retry_most_s, device.channels.size());
  }
  return sum.value();
}

std::string answer(const std::string& text, const rom::Network& network) {
  try {
    const Config config = parse_config(text, "/etc/twin.toml");
    const SpindlePlan plan = bind_config(config, network);
    char numbers[64];
    std::snprintf(numbers, sizeof numbers, "taken %.14g %.14g", sum_of_cycle(plan.cycle), sum_of_rest(plan, config));
    return numbers;
  } catch (const rom::InputError& error) {
    std::string message = error.what();
    std::replace(message.begin(), message.end(), '\n', ' ');
    return message;
  }
}

TEST(RecordedRefusals, of_a_configuration_with_one_mistake) {
  const rom::Network network = rom::tests::make_network_with_laws();
  std::string now = "as it is -> " + answer(tables, network) + "\n";
  for (const tests::TextFault& fault : tests::text_faults(tables, 3)) {
    now += fault.what + " -> " + answer(fault.text, network) + "\n";
  }
  tests::expect_as_recorded("configuration.txt", now, tolerance);
}

}  // namespace config_recorded_refusals_test
}  // namespace spindle_twin::firmware

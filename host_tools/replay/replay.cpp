#include "host_tools/replay/replay.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <iterator>

#include "firmware/cycle/cycle.hpp"
#include "firmware/keep/history.hpp"
#include "rom/integrate/fallback_stepper.hpp"

namespace spindle_twin::host_tools {
namespace {

using firmware::Reading;
using firmware::SignalSource;

constexpr std::int64_t start_ns = 1'000'000'000'000'000'000;  // anything but 0, which means never read
constexpr double ns_per_s = 1e9;

/// What device and PLC have said so far.
struct Inputs {
  firmware::DeviceFrame frame;
  firmware::PlcCommand command;
};

void feed_signals(const LogRow& row, const Log& log, std::int64_t now_ns, Inputs& inputs) {
  inputs.frame.connected = row.connected;
  for (std::size_t s = 0; s < row.signals.size(); ++s) {
    if (log.has_signal[s]) inputs.frame.signals[s] = {row.signals[s], now_ns};
  }
}

/// As it was when it was as old as that; an age that is no number is that of a reading that never came.
Reading reading_of_age(double value, double age_s, double clock_rate, std::int64_t now_ns) {
  if (!std::isfinite(age_s)) return {};
  return {value, now_ns - std::llround(age_s / clock_rate * ns_per_s)};
}

/// A row of a plain log: an empty cell leaves the reading before. A measured length is a probe's reading, which counts
/// where the plan has a probe there.
void feed_sample(const LogRow& row, const Log& log, std::int64_t row_ns, Inputs& inputs) {
  feed_signals(row, log, row_ns, inputs);
  for (std::size_t k = 0; k < row.measured_K.size(); ++k) {
    if (std::isfinite(row.measured_K[k])) inputs.frame.sensors[k] = {row.measured_K[k], row_ns};
  }
  for (std::size_t d = 0; d < row.deformation_m.size(); ++d) {
    if (std::isfinite(row.deformation_m[d])) inputs.frame.displacements[d] = {row.deformation_m[d], row_ns};
  }
}

/// A row of a history: what the cycle of that row saw, readings as old as they were then.
void feed_cycle(const LogRow& row, const Log& log, double clock_rate, std::int64_t now_ns, Inputs& inputs) {
  feed_signals(row, log, now_ns, inputs);
  for (std::size_t k = 0; k < row.raw_K.size(); ++k) {
    const bool without_age = std::isnan(row.age_s[k]) && std::isfinite(row.raw_K[k]);
    inputs.frame.sensors[k] = reading_of_age(row.raw_K[k], without_age ? 0.0 : row.age_s[k], clock_rate, now_ns);
  }
  for (std::size_t d = 0; d < row.probe_m.size(); ++d) {
    inputs.frame.displacements[d] = reading_of_age(row.probe_m[d], row.probe_age_s[d], clock_rate, now_ns);
  }
  firmware::PlcCommand& command = inputs.command;
  if (log.switched_correction) {
    command.correction = row.correction_enabled ? firmware::SwitchOrder::on : firmware::SwitchOrder::off;
  }
  command.tare_orders = row.tare_orders;
  command.tare_order = row.tared ? firmware::TareOrder::take : firmware::TareOrder::clear;
  command.displacements = row.length_orders;
  command.displacement = row.length;
  command.sensor_orders = row.sensor_orders;
  command.sensor_order = row.sensor_order;
}

using OnCycle = std::function<void(const ReplayedCycle&)>;

void replay_history(firmware::Cycle& cycle, const firmware::CyclePlan& plan, const Log& log, const OnCycle& on_cycle) {
  Inputs inputs;
  for (const LogRow& row : log.rows) {
    const std::int64_t now_ns = start_ns + row.clock_ns;
    feed_cycle(row, log, plan.clock_rate, now_ns, inputs);
    firmware::Snapshot snapshot = cycle.step(inputs.frame, inputs.command, now_ns, row.missed);
    snapshot.model_time_s += log.before_s;
    on_cycle({row.time_s, row.time_s + plan.period_s, snapshot});
  }
}

void replay_samples(firmware::Cycle& cycle, const firmware::CyclePlan& plan, const Log& log, const OnCycle& on_cycle) {
  const double first_s = log.rows.front().time_s;
  const auto at_ns = [&](double time_s) { return start_ns + std::llround((time_s - first_s) * ns_per_s); };
  const std::int64_t last_ns = at_ns(log.rows.back().time_s);
  Inputs inputs;
  std::size_t next = 0;
  for (std::int64_t n = 0;; ++n) {
    const double time_s = first_s + static_cast<double>(n) * plan.period_s;
    const std::int64_t now_ns = at_ns(time_s);
    if (now_ns > last_ns) return;
    for (; next < log.rows.size() && at_ns(log.rows[next].time_s) <= now_ns; ++next) {
      feed_sample(log.rows[next], log, at_ns(log.rows[next].time_s), inputs);
    }
    firmware::Snapshot snapshot = cycle.step(inputs.frame, inputs.command, now_ns, 0);
    snapshot.model_time_s = time_s + plan.period_s;
    on_cycle({time_s, snapshot.model_time_s, snapshot});
  }
}

}  // namespace

void replay(const rom::Network& network, firmware::CyclePlan plan, const Log& log,
            const std::function<void(const ReplayedCycle&)>& on_cycle) {
  replay(network, std::move(plan), log, on_cycle, [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
}

void replay(const rom::Network& network, firmware::CyclePlan plan, const Log& log,
            const std::function<void(const ReplayedCycle&)>& on_cycle, const firmware::MakeStepper& make_stepper) {
  for (std::size_t s = 0; s < plan.signals.size(); ++s) {
    firmware::SignalPlan& signal = plan.signals[s];
    if (!log.has_signal[s]) {
      if (signal.source != SignalSource::none) signal.source = SignalSource::constant;
    } else {
      signal.source = SignalSource::device;
      if (log.cycle_s) signal = {SignalSource::device, signal.value, -1e300, 1e300, 0.0};  // it was judged already
    }
  }
  firmware::Cycle cycle(network, plan, make_stepper);
  log.cycle_s ? replay_history(cycle, plan, log, on_cycle) : replay_samples(cycle, plan, log, on_cycle);
}

std::string replay_header(const rom::Network& network) {
  std::string header = firmware::history_header(network);
  for (const rom::KeyPoint& point : network.key_points) header.append(",error.").append(point.name).append("_K");
  return header;
}

std::string replay_row(const firmware::Snapshot& snapshot, const std::vector<double>& error_K) {
  std::string row = firmware::history_row(snapshot);
  for (const double value : error_K) {
    row += ',';
    if (std::isfinite(value)) fmt::format_to(std::back_inserter(row), "{:.9g}", value);
  }
  return row;
}

}  // namespace spindle_twin::host_tools

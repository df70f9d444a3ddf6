#include "host_tools/replay/replay.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <memory>

#include "firmware/cycle/cycle.hpp"
#include "firmware/keep/history.hpp"
#include "rom/integrate/fallback_stepper.hpp"

namespace spindle_twin::host_tools {
namespace {

using firmware::Reading;
using firmware::SignalSource;

constexpr std::int64_t start_ns = 1'000'000'000'000'000'000;  // anything but 0, which means never read
constexpr double ns_per_s = 1e9;

/// Time as the log has it: waking the cycle moves the clock on, hands over the readings that are due, and takes the
/// snapshot of the cycle before.
class LogClock final : public firmware::Clock {
 public:
  LogClock(const firmware::CyclePlan& plan, const Log& log, const std::function<void(const ReplayedCycle&)>& on_cycle)
      : plan_(plan), log_(log), on_cycle_(on_cycle), ns_per_model_s_(ns_per_s / plan.clock_rate) {
    frame_.connected = true;
  }

  std::int64_t now_ns() const override { return now_ns_; }

  void sleep_until_ns(std::int64_t time_ns) override {
    hand_out();
    if (next_ == log_.rows.size() && (log_.cycle_s || time_ns > log_ns(log_.rows.back().time_s))) {
      stop_ = true;  // and the time stays, so that no further cycle is due
      return;
    }
    now_ns_ = time_ns;
    if (log_.cycle_s) {
      wake_for_cycle();
    } else {
      while (next_ < log_.rows.size() && log_ns(log_.rows[next_].time_s) <= now_ns_) take(log_.rows[next_++]);
    }
  }

  void hand_out() {
    firmware::Snapshot snapshot;
    while (ring_.pop(snapshot)) {
      const double began_s =
          log_.rows.front().time_s + static_cast<double>(snapshot.time_ns - first_ns_) / ns_per_model_s_;
      const double end_s = began_s + plan_.period_s;
      snapshot.model_time_s = log_.cycle_s ? snapshot.model_time_s + log_.before_s : end_s;
      on_cycle_({began_s, end_s, snapshot});
    }
  }

  firmware::CyclePorts ports() { return {device_, plc_, server_, &ring_, nullptr}; }
  const std::atomic<bool>& stop() const { return stop_; }

 private:
  std::int64_t log_ns(double time_s) const {
    return start_ns + std::llround((time_s - log_.rows.front().time_s) * ns_per_model_s_);
  }

  /// The daemon came as late as it says.
  void wake_for_cycle() {
    const auto period_ns = static_cast<std::int64_t>(ns_per_s * plan_.period_s / plan_.clock_rate);
    const LogRow& row = log_.rows[next_];
    if (now_ns_ < due_ns_) return;
    now_ns_ = due_ns_ + row.missed * period_ns;
    if (next_ == 0) first_ns_ = now_ns_;
    due_ns_ = now_ns_ + period_ns;
    take(row);
    ++next_;
  }

  void take(const LogRow& row) {
    frame_.connected = row.connected;
    for (std::size_t s = 0; s < row.signals.size(); ++s) {
      if (log_.has_signal[s]) frame_.signals[s] = {row.signals[s], now_ns_};
    }
    for (std::size_t k = 0; k < row.measured_K.size(); ++k) {
      if (log_.has_sensor[k]) take_sensor(row, k);
    }
    device_.write(frame_);
    if (log_.cycle_s) take_orders(row);
  }

  void take_sensor(const LogRow& row, std::size_t k) {
    Reading& reading = frame_.sensors[k];
    if (std::isfinite(row.age_s[k])) {
      reading = {row.measured_K[k], now_ns_ - std::llround(row.age_s[k] * ns_per_model_s_)};
    } else if (std::isfinite(row.measured_K[k])) {
      reading = {row.measured_K[k], log_.cycle_s ? now_ns_ : log_ns(row.time_s)};
    } else if (log_.cycle_s) {
      reading = {};  // never read
    }
  }

  void take_orders(const LogRow& row) {
    if (log_.switched_correction) {
      command_.correction = row.correction_enabled ? firmware::CorrectionOrder::on : firmware::CorrectionOrder::off;
    }
    if (row.tare_m != tare_m_) {
      command_.tare_order = row.tare_m == 0.0 ? firmware::TareOrder::clear : firmware::TareOrder::take;
      ++command_.tare_orders;
      tare_m_ = row.tare_m;
    }
    plc_.write(command_);
  }

  const firmware::CyclePlan& plan_;
  const Log& log_;
  const std::function<void(const ReplayedCycle&)>& on_cycle_;
  double ns_per_model_s_;
  std::int64_t now_ns_ = start_ns;
  std::int64_t first_ns_ = start_ns;
  std::int64_t due_ns_ = start_ns;
  std::size_t next_ = 0;
  double tare_m_ = 0.0;
  firmware::DeviceFrame frame_;
  firmware::PlcCommand command_;
  firmware::Latest<firmware::DeviceFrame> device_;
  firmware::Latest<firmware::PlcCommand> plc_;
  firmware::Latest<firmware::Snapshot> server_;
  firmware::SnapshotRing ring_;
  std::atomic<bool> stop_{false};
};

}  // namespace

void replay(const rom::Network& network, firmware::CyclePlan plan, const Log& log,
            const std::function<void(const ReplayedCycle&)>& on_cycle) {
  for (std::size_t s = 0; s < plan.signals.size(); ++s) {
    firmware::SignalPlan& signal = plan.signals[s];
    if (!log.has_signal[s]) {
      signal.source = SignalSource::constant;
    } else {
      signal.source = SignalSource::device;
      if (log.cycle_s) signal = {SignalSource::device, signal.value, -1e300, 1e300, 0.0};  // it was judged already
    }
  }
  firmware::Cycle cycle(network, plan, [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
  const auto clock = std::make_unique<LogClock>(plan, log, on_cycle);
  firmware::run_cycle(cycle, plan, *clock, clock->ports(), clock->stop());
  clock->hand_out();
}

std::string replay_header(const rom::Network& network) {
  std::string header = firmware::history_header(network);
  for (const rom::KeyPoint& point : network.key_points) header.append(",innovation.").append(point.name).append("_K");
  return header;
}

std::string replay_row(const firmware::Snapshot& snapshot, const std::vector<double>& innovation_K) {
  std::string row = firmware::history_row(snapshot);
  for (const double value : innovation_K) {
    row += ',';
    if (std::isfinite(value)) fmt::format_to(std::back_inserter(row), "{:.9g}", value);
  }
  return row;
}

}  // namespace spindle_twin::host_tools

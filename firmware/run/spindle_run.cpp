#include "firmware/run/spindle_run.hpp"

#include <spdlog/spdlog.h>

#include <string>
#include <utility>

#include "firmware/keep/state_files.hpp"
#include "firmware/watch/keep_running.hpp"
#include "firmware/watch/log.hpp"

namespace spindle_twin::firmware {
namespace {

/// The only spindle is also asked for by clients that have no setting for the unit.
Units units_of(const PreparedSpindle& spindle) {
  return spindle.name.empty() ? units_of_one_spindle() : Units().set(static_cast<std::size_t>(spindle.unit));
}

/// The work of a thread that may begin anew where it threw.
template <class Runs>
auto begun_again(const char* what, Runs& runs, const std::atomic<bool>& stop) {
  return [what, &runs, &stop] { keep_running(what, stop, [&] { runs.run(stop); }); };
}

}  // namespace

SpindleRun::SpindleRun(PreparedSpindle& spindle, Clock& clock, const std::atomic<std::uint64_t>& log_lines_dropped)
    : spindle_(spindle),
      clock_(clock),
      order_keeper_(spindle.config.keep.orders_path, spindle.file.sha256, desk_, troubles_),
      events_(spindle.file.network),
      exchange_(spindle.cycle, spindle.config.exchange.plan) {
  const LogName name(spindle.name);
  troubles_.log_lines_dropped = &log_lines_dropped;
  for (const std::string& path : state_files(spindle.config)) {
    if (const int removed = remove_left_overs(path)) spdlog::info("{}: {} unfinished files removed", path, removed);
  }
  const std::vector<DevicePlan>& devices = spindle.plan.devices;
  for (std::size_t d = 0; d < devices.size(); ++d) {
    if (devices[d].channels.empty()) continue;
    devices_.push_back(std::make_unique<DeviceThread>(devices[d], d, clock_, readings_.of(d)));
  }
  if (!spindle.config.history.path.empty()) {
    history_ = make_history(spindle.config.history, spindle.file.network, troubles_);
  }
}

void SpindleRun::recall() {
  const LogName name(spindle_.name);
  checkpoint_ = look_for_checkpoint(spindle_.config.keep);
  orders_ = recall_orders(spindle_.config.keep.orders_path, spindle_.file.sha256, checkpoint_, spindle_.sha256_before);
  order_keeper_.begin_with(orders_);
}

SpindlePorts SpindleRun::ports() { return {units_of(spindle_), snapshots_, signals_, desk_}; }

/// A thread whose lines of the log name the spindle.
template <class Work>
void SpindleRun::run(std::vector<std::thread>& threads, Work work) {
  threads.emplace_back([this, work = std::move(work)] {
    const LogName name(spindle_.name);
    work();
  });
}

void SpindleRun::begin(const ShownTo& shown) {
  const LogName name(spindle_.name);
  const CyclePlan& plan = spindle_.plan.cycle;
  const KeepPlan& keep = spindle_.config.keep;
  const StartingPoint start{spindle_.file.sha256, plan.clock_rate, unix_now_s()};
  const Resumed resumed = resume_from_checkpoint(keep, checkpoint_, start, spindle_.cycle, &stop_);
  checkpoint_.reset();
  if (resumed == Resumed::given_up) return;
  spindle_.cycle.stand_by_orders(orders_);
  keeper_.emplace(keep, spindle_.file.sha256, plan.clock_rate, spindle_.cycle, &order_keeper_, &troubles_);

  if (!spindle_.config.exchange.slot.empty()) {
    slot_.emplace(spindle_, exchange_, [this] { keeper_->keep_now(); });
    run(threads_, begun_again("exchange", *slot_, stop_));
  }
  for (const auto& device : devices_) run(threads_, begun_again("device", *device, stop_));
  if (history_) run(after_cycle_, begun_again("history", *history_, stop_after_cycle_));
  run(after_cycle_, begun_again("keeping of orders", order_keeper_, stop_after_cycle_));
  run(after_cycle_, begun_again("log of events", events_, stop_after_cycle_));
  run(threads_, begun_again("checkpoint", *keeper_, stop_));
  run(threads_, [this, shown] { run_cycle(spindle_.cycle, spindle_.plan.cycle, clock_, cycle_ports(shown), stop_); });
}

void SpindleRun::stop() {
  end();
  const LogName name(spindle_.name);
  for (std::thread& thread : std::exchange(threads_, {})) thread.join();
  stop_after_cycle_.store(true);
  for (std::thread& thread : std::exchange(after_cycle_, {})) thread.join();
  if (keeper_) keeper_->keep_last(exchange_.kept());
  keeper_.reset();
}

CyclePorts SpindleRun::cycle_ports(const ShownTo& shown) {
  return {readings_,
          signals_,
          snapshots_,
          history_ ? &history_->ring() : nullptr,
          history_ ? &history_->lost() : nullptr,
          &keeper_->remembered(),
          &desk_,
          &events_.tap(),
          &troubles_,
          &pulse_,
          shown,
          &exchange_};
}

}  // namespace spindle_twin::firmware

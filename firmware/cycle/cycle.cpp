#include "firmware/cycle/cycle.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/cycle/exchange.hpp"
#include "firmware/watch/deadline.hpp"

namespace spindle_twin::firmware {

const Snapshot& Cycle::step(const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns,
                            std::int64_t missed) {
  const double period_s = plan_.period_s;
  const double gap_s = period_s * static_cast<double>(missed);
  if (!has_stepped_) first_ns_ = now_ns;
  has_stepped_ = true;
  snapshot_.clock_ns = now_ns - first_ns_;
  const double since_s = catch_up(gap_s);

  sense(plan_, frame, command, now_ns, sensed_);
  take_orders(command);  // before the tare is subtracted: an order to change it counts for these readings already
  subtract_tare(watch_, sensed_);
  judge(plan_, sensed_, judgement_);
  set_operating(network_, judgement_, operating_);
  if (started_) {
    const Period since{snapshot_.model_time_s, since_s};
    watch_sensors({network_, plan_, sensed_, model_, uncorrected_, since}, watch_, corrector_, judgement_);
  }
  publish_inputs(sensed_, judgement_, snapshot_);
  snapshot_.quality = judgement_.quality;

  if (started_ || ready_to_start()) {
    take_probes(plan_, sensed_, snapshot_.tare_m, corrector_);
    const CorrectedInputs inputs =
        correct(sensed_, judgement_, operating_, {snapshot_.model_time_s, period_s}, model_, corrector_);
    watch_update(network_, operating_, model_, watch_, corrector_);
    note(integrate(network_, inputs.operating, inputs.factors, period_s, model_));
    predict(network_, model_, inputs.factors.expansion);
    if (plan_.compare_uncorrected) {
      integrate(network_, operating_, corrector_.none, period_s, uncorrected_);
      predict(network_, uncorrected_);
      guard_prediction();
      publish_uncorrected(uncorrected_, snapshot_);
    }
    publish_prediction();
    heat_paths_.publish(model_, snapshot_);
    publish_correction(corrector_, inputs.factors, snapshot_);
    publish_estimate(corrector_, snapshot_);
    publish_health(watch_, corrector_, snapshot_);
    if (forecast_) forecast_->step(model_, inputs.operating, inputs.factors);
    snapshot_.model_time_s += period_s;
  } else {
    waited_s_ += gap_s + period_s;
  }
  label(missed);
  compensation_.step(judgement_.good, judgement_.configured, period_s, snapshot_);
  if (forecast_) publish_forecast(*forecast_, plan_.compensation, snapshot_);
  return snapshot_;
}

void Cycle::publish_prediction() {
  const double most_m = plan_.slew_m_per_s * plan_.period_s;
  const double before_m = snapshot_.deformation_m[0];
  publish_corrected(model_, most_m, plan_.output_limit_m, snapshot_);
  if (tare_to_come_m_ == 0.0) return;
  move_tare(most_m, snapshot_.deformation_m[0] - before_m);
  publish_nose(plan_.output_limit_m[0], snapshot_);
}

void run_cycle(Cycle& cycle, const CyclePlan& plan, Clock& clock, const CyclePorts& ports,
               const std::atomic<bool>& stop) {
  DeviceFrame frame;
  PlcSignals told;
  PlcCommand command = ports.orders != nullptr ? ports.orders->first_command() : PlcCommand{};
  NetworkExchange no_exchange(cycle, {});
  NetworkExchange& exchange = ports.exchange != nullptr ? *ports.exchange : no_exchange;
  Deadline deadline(clock.now_ns(), static_cast<std::int64_t>(1e9 * plan.period_s / plan.clock_rate));
  while (!stop.load(std::memory_order_relaxed)) {
    constexpr std::int64_t longest_sleep_ns = 100'000'000;  // so that a long period does not delay the stop
    const std::int64_t before_ns = clock.now_ns();
    clock.sleep_until_ns(std::min(deadline.due_ns(), before_ns + longest_sleep_ns));
    const std::int64_t now_ns = clock.now_ns();
    if (now_ns < deadline.due_ns()) continue;

    ports.devices.read(frame);
    ports.plc.read(told);
    command.signals = told.values;
    command.alive_ns = told.alive_ns;
    if (ports.orders != nullptr) ports.orders->hand_out(command);
    if (ports.troubles != nullptr) exchange.note_troubles(*ports.troubles);
    Snapshot snapshot = exchange.step(frame, command, now_ns, deadline.take(now_ns));
    if (ports.orders != nullptr) {
      const StandingOrders standing = exchange.kept().standing_orders();
      if (exchange.take_kept_changed()) ports.orders->renew(standing);
      ports.orders->settle(exchange.order_results(), standing, snapshot);
    }
    snapshot.time_ns = clock.now_ns();
    ports.server.write(snapshot);
    if (ports.events != nullptr) ports.events->write(snapshot);
    for (Latest<Snapshot>* const tap : ports.shown) {
      if (tap != nullptr) tap->write(snapshot);
    }
    if (ports.remembered != nullptr && ports.remembered->asked()) {
      exchange.kept().remember(ports.remembered->value);
      ports.remembered->fill();
    }
    if (ports.pulse != nullptr) {
      ports.pulse->predicts.store(snapshot.state == State::running || snapshot.state == State::degraded,
                                  std::memory_order_relaxed);
      ports.pulse->waits.store((snapshot.fault & bits(Fault::start_timed_out)) != 0, std::memory_order_relaxed);
      ports.pulse->cycles.fetch_add(1, std::memory_order_release);
    }
    if (ports.history != nullptr && !ports.history->push(snapshot)) ++*ports.lost;
  }
}

}  // namespace spindle_twin::firmware

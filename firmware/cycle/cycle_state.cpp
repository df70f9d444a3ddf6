#include <algorithm>
#include <cmath>
#include <utility>

#include "correction/growth/growth_reading.hpp"
#include "firmware/cycle/cycle.hpp"
#include "firmware/cycle/plausible.hpp"

namespace spindle_twin::firmware {

Cycle::Cycle(const rom::Network& network, const CyclePlan& plan, const MakeStepper& make_stepper,
             std::shared_ptr<const rom::NetworkOperator> shared)
    : network_(network),
      shared_operator_(std::move(shared)),
      plan_(plan),
      model_(make_model(network, make_stepper)),
      uncorrected_(make_model(network, make_stepper)),
      heat_paths_(network, shared_operator_),
      corrector_(make_corrector(network, plan, make_stepper, shared_operator_)),
      watch_(make_watch(network, plan, corrector_)),
      judgement_(first_judgement(plan)),
      operating_(network.boundaries.operating),
      start_K_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.nodes.size()))),
      snapshot_(first_snapshot(network)),
      compensation_(plan.compensation) {
  if (plan.forecast.ahead_s > 0.0 && !network.deformations.empty()) {
    forecast_.emplace(network, plan.forecast, make_stepper);
  }
}

bool Cycle::ready_to_start() {
  if (plan_.start_nodes_K.size() == start_K_.size()) {
    start_K_ = plan_.start_nodes_K;
    start();
    return true;
  }
  if (plan_.start_temperature_K) {
    start_from(*plan_.start_temperature_K);
    return true;
  }
  const bool patient = waited_s_ < plan_.start_wait_s;
  if (judgement_.good == 0 || (patient && judgement_.good < judgement_.configured)) return false;
  double sum_K = 0.0;
  for (std::size_t k = 0; k < judgement_.sensors.size(); ++k) {
    if (judgement_.sensors[k] == SensorQuality::good) sum_K += sensed_.sensors[k].value;
  }
  start_from(sum_K / static_cast<double>(judgement_.good));
  return true;
}

void Cycle::start_from(double temperature_K) {
  start_K_.setConstant(temperature_K);
  start();
}

/// At start_K_.
void Cycle::start() {
  for (Model* model : {&model_, &uncorrected_}) {
    model->stepper->set_temperatures(start_K_);
    predict(network_, *model);
  }
  started_ = true;
}

double Cycle::catch_up(double gap_s) {
  if (gap_s == 0.0 || !started_) return plan_.period_s;
  constexpr double longest_step_s = 60.0;
  constexpr double most_steps = 60.0;
  const int steps = static_cast<int>(std::clamp(std::ceil(gap_s / longest_step_s), 1.0, most_steps));
  const double advance_s = gap_s / steps;
  double since_s = plan_.period_s;
  sensed_ = {};
  judgement_.sensors.fill(SensorQuality::never_read);
  for (int step = 0; step < steps; ++step) {
    const Period since{snapshot_.model_time_s, std::exchange(since_s, advance_s)};
    watch_gap({network_, plan_, sensed_, model_, uncorrected_, since}, watch_, corrector_, judgement_);
    const CorrectedInputs inputs =
        correct(sensed_, judgement_, operating_, {snapshot_.model_time_s, advance_s}, model_, corrector_);
    watch_update(network_, operating_, model_, watch_, corrector_);
    integrate(network_, inputs.operating, inputs.factors, advance_s, model_);
    predict(network_, model_, inputs.factors.expansion);
    if (plan_.compare_uncorrected) {
      integrate(network_, operating_, corrector_.none, advance_s, uncorrected_);
      predict(network_, uncorrected_);
    }
    snapshot_.model_time_s += advance_s;
  }
  compensation_.pass(gap_s);
  return since_s;
}

void Cycle::take_orders(const PlcCommand& command) {
  const bool on = command.correction == SwitchOrder::as_configured ? plan_.correction_enabled
                                                                   : command.correction == SwitchOrder::on;
  corrector_.enabled = corrector_.corrects && on;
  correction_order_ = command.correction;
  results_.fill(OrderResult::none);
  const auto result_of = [&](OrderKind kind) -> OrderResult& { return results_[static_cast<std::size_t>(kind)]; };
  const bool in_vain = command.correction == SwitchOrder::on && !corrector_.corrects;
  result_of(OrderKind::correction) = in_vain ? OrderResult::refused : OrderResult::done;
  const bool no_such_switch = command.compensation != SwitchOrder::as_configured && network_.deformations.empty();
  result_of(OrderKind::compensation) = no_such_switch ? OrderResult::refused : OrderResult::done;
  compensation_.order(command.compensation);
  const double now_s = 1e-9 * static_cast<double>(snapshot_.clock_ns);
  const OrderResult tried = compensation_.try_value(command.trial, now_s);
  result_of(OrderKind::trial) = network_.deformations.empty() ? OrderResult::refused : tried;
  result_of(OrderKind::length) = take_length(command);
  if (command.sensor_orders != watch_.orders) {
    result_of(OrderKind::sensors) = OrderResult::waiting;
    if (started_) {
      const bool taken = take_sensor_order(command.sensor_order, plan_, judgement_, watch_, corrector_);
      result_of(OrderKind::sensors) = taken ? OrderResult::done : OrderResult::refused;
      watch_.orders = command.sensor_orders;
      snapshot_.sensor_order = command.sensor_order;
      ++snapshot_.sensor_orders;
    }
  }
  if (command.tare_orders != tare_orders_) result_of(OrderKind::tare) = take_tare(command);
  if (command.acknowledgements != acknowledgements_) {
    acknowledgements_ = command.acknowledgements;
    ++acknowledgements_kept_;
    snapshot_.fault &= static_cast<std::uint16_t>(~(bits(Fault::orders_lost) | bits(Fault::integrator_failed)));
    result_of(OrderKind::acknowledge) = OrderResult::done;
  }
}

/// Times the limit of an output, which clamps what is published: a length may show that the limit is too low.
constexpr double beyond_belief = 2.0;

// Before the start there is no elongation yet: lengths and tares wait.

OrderResult Cycle::take_length(const PlcCommand& command) {
  if (length_due_ > 0) return length_result();
  if (command.displacements == displacements_) return OrderResult::none;
  if (!started_) return OrderResult::waiting;
  const Displacement& length = command.displacement;
  const double zero_m = length.output == 0 ? snapshot_.tare_m : 0.0;
  const double elongation_m = length.value_m + zero_m;
  // What no output can be is told to nobody: the history would hand it to whoever judges or fits.
  const bool exists = length.output < network_.deformations.size();
  if (exists && (!correction::is_growth(elongation_m, length.deviation_m) ||
                 std::abs(elongation_m) > beyond_belief * plan_.output_limit_m[length.output])) {
    displacements_ = command.displacements;
    return OrderResult::refused;
  }
  if (waits_for_update(corrector_)) return OrderResult::waiting;
  displacements_ = command.displacements;
  const bool taken = take_displacement(static_cast<int>(length.output), elongation_m, length.deviation_m, corrector_);
  snapshot_.displacement = length;
  ++snapshot_.displacement_orders;
  if (!taken) return OrderResult::refused;
  length_due_ = corrector_.displacements.due;
  return OrderResult::waiting;
}

OrderResult Cycle::length_result() {
  const bool in_time = corrector_.enabled && corrector_.estimator;
  if (in_time && corrector_.estimator->updates() < length_due_) return OrderResult::waiting;
  length_due_ = 0;
  return in_time && corrector_.estimator->displacement_record().fused ? OrderResult::done : OrderResult::refused;
}

OrderResult Cycle::take_tare(const PlcCommand& command) {
  const bool clears = command.tare_order == TareOrder::clear;
  if (!clears && !started_) return OrderResult::waiting;
  if (clears) snapshot_.tare_m = 0.0;
  tare_to_come_m_ = 0.0;
  const bool taken = clears || tare(plan_.output_limit_m[0], snapshot_);
  ++snapshot_.tare_count;
  tare_orders_ = command.tare_orders;
  return taken ? OrderResult::done : OrderResult::refused;
}

StandingOrders Cycle::standing_orders() const {
  StandingOrders orders;
  orders.correction = correction_order_;
  orders.compensation = compensation_.ordered();
  orders.tare_m = snapshot_.tare_m + tare_to_come_m_;
  network_sha256_.copy(orders.network_sha256.data(), orders.network_sha256.size());
  orders.sensor_tares = watch_.tare.count;
  std::copy(watch_.tare.offset_K.begin(), watch_.tare.offset_K.end(), orders.sensor_tare_K.begin());
  std::copy(watch_.tare.deviation_K.begin(), watch_.tare.deviation_K.end(), orders.sensor_tare_deviation_K.begin());
  orders.acknowledgements = acknowledgements_kept_;
  orders.lost = (snapshot_.fault & bits(Fault::orders_lost)) != 0;
  return orders;
}

void Cycle::stand_by_orders(const StandingOrders& orders) {
  correction_order_ = orders.correction;
  compensation_.order(orders.compensation);
  acknowledgements_kept_ = orders.acknowledgements;
  if (orders.lost) snapshot_.fault |= bits(Fault::orders_lost);
  correction::SensorTare tare = watch_.tare;
  tare.count = orders.sensor_tares;
  std::copy_n(orders.sensor_tare_K.begin(), tare.offset_K.size(), tare.offset_K.begin());
  std::copy_n(orders.sensor_tare_deviation_K.begin(), tare.deviation_K.size(), tare.deviation_K.begin());
  if (started_) {
    set_tare(tare, plan_, watch_, corrector_);
  } else {
    watch_.tare = tare;  // the estimator has no offsets yet
  }
  snapshot_.tare_m = orders.tare_m;
  if (!started_) return;
  publish_corrected(model_, 0.0, plan_.output_limit_m, snapshot_);
  compensation_.begin_at(snapshot_);
}

void Cycle::note_troubles(const Troubles& troubles) {
  outside_faults_ = troubles.faults();
  snapshot_.history_rows_lost = troubles.history_rows_lost.load(std::memory_order_relaxed);
  if (troubles.log_lines_dropped)
    snapshot_.log_lines_dropped = troubles.log_lines_dropped->load(std::memory_order_relaxed);
}

double Cycle::expansion() const {
  return corrector_.enabled && corrector_.estimator ? corrector_.estimator->factors().expansion : 1.0;
}

void Cycle::guard_prediction() {
  constexpr double shown_for_s = 600.0;
  const double now_s = snapshot_.model_time_s;
  const bool implausible = outside_K(network_, judgement_, sensed_, model_, uncorrected_) > plausible_K;
  if (implausible) {
    implausible_until_s_ = now_s + shown_for_s;
    model_.stepper->set_temperatures(uncorrected_.stepper->temperatures_K());
    if (corrector_.estimator) corrector_.estimator->reset(now_s, model_.stepper->temperatures_K(), operating_);
    if (corrector_.estimator) watch_anew(*corrector_.estimator, watch_);
    predict(network_, model_, expansion());
  }
  snapshot_.fault &= static_cast<std::uint16_t>(~bits(Fault::implausible_prediction));
  if (now_s < implausible_until_s_) snapshot_.fault |= bits(Fault::implausible_prediction);
}

void Cycle::note(Integrated integrated) {
  snapshot_.fault &= static_cast<std::uint16_t>(~bits(Fault::prediction_lost));
  if (integrated == Integrated::by_cvode) return;
  snapshot_.fault |= bits(Fault::integrator_failed);
  snapshot_.quality |= bits(Quality::integrator_fallback);
  if (integrated == Integrated::not_at_all) snapshot_.fault |= bits(Fault::prediction_lost);
}

void Cycle::label(std::int64_t missed) {
  ++snapshot_.sequence;
  snapshot_.overruns += static_cast<std::uint32_t>(missed);
  constexpr auto of_others = static_cast<std::uint16_t>(bits(Fault::orders_not_kept) | bits(Fault::history_lost) |
                                                        bits(Fault::checkpoint_lost));
  snapshot_.fault &= static_cast<std::uint16_t>(~(bits(Fault::start_timed_out) | of_others));
  snapshot_.fault |= static_cast<std::uint16_t>(outside_faults_ & of_others);
  // With one good reading the next cycle starts from it.
  const bool nothing_to_start_from = !started_ && judgement_.good == 0;
  if (nothing_to_start_from && waited_s_ >= plan_.start_wait_s) snapshot_.fault |= bits(Fault::start_timed_out);

  if (missed > 0) snapshot_.quality |= bits(Quality::overrun);
  if (snapshot_.tare_m != 0.0) snapshot_.quality |= bits(Quality::tared);
  if (network_.certificate.cases == 0) snapshot_.quality |= bits(Quality::uncertified);
  if (!corrector_.enabled) {
    snapshot_.quality |= bits(Quality::correction_off);
  } else if (corrector_.freeze > bits(CorrectionFreeze::waiting) &&
             corrector_.freeze != bits(CorrectionFreeze::deadband)) {
    snapshot_.quality |= bits(Quality::correction_frozen);
  }

  constexpr auto harmless = static_cast<std::uint16_t>(
      bits(Quality::correction_off) | bits(Quality::correction_frozen) | bits(Quality::overrun) | bits(Quality::tared) |
      bits(Quality::uncertified) | bits(Quality::slewing) | bits(Quality::sensor_tare_offered));
  const bool stopped = (snapshot_.fault & (bits(Fault::prediction_lost) | bits(Fault::start_timed_out))) != 0;
  if (stopped) {
    snapshot_.state = State::fault;
  } else if (!started_) {
    snapshot_.state = State::starting;
  } else {
    // Without a row or a checkpoint the prediction is as good as before.
    constexpr auto aside = static_cast<std::uint16_t>(bits(Fault::history_lost) | bits(Fault::checkpoint_lost));
    const bool troubled = (snapshot_.quality & static_cast<std::uint16_t>(~harmless)) != 0 ||
                          (snapshot_.fault & static_cast<std::uint16_t>(~aside)) != 0;
    snapshot_.state = troubled ? State::degraded : State::running;
  }
}

}  // namespace spindle_twin::firmware

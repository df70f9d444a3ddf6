#include <algorithm>
#include <cmath>

#include "firmware/cycle/cycle.hpp"
#include "firmware/cycle/plausible.hpp"

namespace spindle_twin::firmware {

Cycle::Cycle(const rom::Network& network, const CyclePlan& plan, const MakeStepper& make_stepper)
    : network_(network),
      plan_(plan),
      model_(make_model(network, make_stepper)),
      uncorrected_(make_model(network, make_stepper)),
      corrector_(make_corrector(network, plan, make_stepper)),
      watch_(make_watch(network, plan, corrector_)),
      judgement_(first_judgement(plan)),
      operating_(network.boundaries.operating),
      start_K_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.nodes.size()))),
      snapshot_(first_snapshot(network)) {}

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

void Cycle::take_orders(const PlcCommand& command) {
  const bool on = command.correction == CorrectionOrder::as_configured ? plan_.correction_enabled
                                                                       : command.correction == CorrectionOrder::on;
  corrector_.enabled = corrector_.corrects && on;
  // Before the start there is no elongation yet: the orders wait.
  if (started_ && command.displacements != displacements_) {
    const Displacement& length = command.displacement;
    const double zero_m = length.output == 0 ? snapshot_.tare_m : 0.0;
    take_displacement(static_cast<int>(length.output), length.value_m + zero_m, length.sd_m, corrector_);
    displacements_ = command.displacements;
    snapshot_.displacement = length;
    ++snapshot_.displacement_orders;
  }
  if (started_ && command.sensor_orders != watch_.orders) {
    take_sensor_order(command.sensor_order, plan_, judgement_, watch_, corrector_);
    watch_.orders = command.sensor_orders;
    snapshot_.sensor_order = command.sensor_order;
    ++snapshot_.sensor_orders;
  }
  if (command.tare_orders == tare_orders_) return;
  if (command.tare_order == TareOrder::take && !started_) return;
  if (command.tare_order == TareOrder::take) {
    tare(snapshot_);
  } else {
    snapshot_.tare_m = 0.0;
  }
  ++snapshot_.tare_count;
  tare_orders_ = command.tare_orders;
}

void Cycle::guard_prediction() {
  constexpr double shown_for_s = 600.0;
  const double now_s = snapshot_.model_time_s;
  const bool implausible = outside_K(network_, judgement_, sensed_, model_, uncorrected_) > plausible_K;
  if (implausible) {
    implausible_until_s_ = now_s + shown_for_s;
    model_.stepper->set_temperatures(uncorrected_.stepper->temperatures_K());
    predict(network_, model_);
    if (corrector_.estimator) corrector_.estimator->reset(now_s, model_.stepper->temperatures_K(), operating_);
    if (corrector_.estimator) follow_estimator(*corrector_.estimator, watch_);
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
  snapshot_.fault &= static_cast<std::uint16_t>(~bits(Fault::start_timed_out));
  if (!started_ && waited_s_ >= plan_.start_wait_s) snapshot_.fault |= bits(Fault::start_timed_out);

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
    const bool troubled = (snapshot_.quality & static_cast<std::uint16_t>(~harmless)) != 0 || snapshot_.fault != 0;
    snapshot_.state = troubled ? State::degraded : State::running;
  }
}

}  // namespace spindle_twin::firmware

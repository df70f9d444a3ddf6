#include <algorithm>

#include "correction/estimator/reduced_chi_square.hpp"
#include "firmware/cycle/watch_sensors.hpp"

// After each update of the estimator: what it said of the sensors, and what the estimate goes over to for it.
namespace spindle_twin::firmware {
namespace {

/// Where and with what the estimate is changed.
struct Watched {
  const rom::Network& network;
  const rom::OperatingState& operating;
  Model& model;
  SensorWatch& watch;
  Corrector& corrector;
  correction::EstimatorCorrection& estimator;
};

/// All filters beside the estimator's begin anew from it; an opinion that is pending goes on.
void follow_estimator(const correction::EstimatorCorrection& estimator, SensorWatch& watch) {
  watch.others->follow(estimator);
  if (watch.heat) watch.heat->follow(estimator);
}

/// The estimator has gone over to another filter, and the model with it.
void set_model(const Watched& of) {
  of.model.stepper->set_temperatures(of.estimator.corrected_nodes_K());
  with_biases(of.operating, of.corrector);
  note_corrected(of.network, of.model, of.watch);
}

/// Whether the readings are better explained by a heat that no source explains, to which the estimator then goes over.
bool explained_by_heat(const Watched& of) {
  SensorWatch& watch = of.watch;
  if (!watch.heat) return false;
  const bool open = of.estimator.heats_are_open();
  if (open) {
    watch.seen.heats_were_open = true;
    return false;
  }
  if (watch.seen.heats_were_open) watch.heat->follow(of.estimator);
  watch.seen.heats_were_open = false;
  if (!watch.heat->update(of.estimator)) return false;
  of.estimator.open_heats(watch.heat->filter(), of.operating);
  follow_estimator(of.estimator, watch);
  set_model(of);
  return true;
}

/// No filter has done without the two that were swapped: the estimate goes back to its priors where they may have been
/// so from the start, and to what it was before where they were right before a gap, or the start is longer ago than
/// movement is remembered.
void leave_pair_out(bool over_gap, const Watched& of) {
  const bool from_start = !over_gap && of.estimator.age_s() < of.watch.health->limits().swap_memory_s;
  of.estimator.adopt(from_start ? of.estimator.prior() : of.watch.others->before(of.estimator), of.operating);
  of.watch.opinion->drop();
  follow_estimator(of.estimator, of.watch);
  set_model(of);
}

/// Filters that were sure of the old offset would hold it against the channel: they begin anew.
void open_offset(Eigen::Index channel, const Watched& of) {
  of.estimator.widen_offset(channel, of.watch.health->limits().return_offset_deviation_K);
  follow_estimator(of.estimator, of.watch);
}

std::size_t key_point_of(Eigen::Index channel, const Corrector& corrector) {
  return corrector.channels[static_cast<std::size_t>(channel)].key_point;
}

/// The sensor has failed: the estimator goes over to the filter that has done without it, from before it was loosened
/// where an opinion has kept that.
void leave_out(Eigen::Index channel, const Watched& of) {
  SensorWatch& watch = of.watch;
  if (watch.opinion->sensor() == channel) {
    of.estimator.adopt(watch.opinion->filter(), of.operating);
    follow_estimator(of.estimator, watch);
  } else {
    of.estimator.adopt(watch.others->without(channel), of.operating);
    watch.others->settle_on(channel);
    if (watch.heat) watch.heat->follow(of.estimator);
  }
  watch.opinion->drop();
  set_model(of);
}

/// The sensor that was blamed first has failed, or has another offset, where what is kept says so.
bool leave_suspect_out(const Watched& of) {
  // Whoever is right then, the machine is an unlikely one: nothing is laid to the sensor.
  if (is_unlikely_machine(of.estimator.parameters(), of.watch.opinion->filter())) return false;
  const Eigen::Index channel = of.watch.opinion->sensor();
  const correction::Misfit& misfit = of.watch.opinion->misfit();
  const correction::HealthVerdict verdict = of.watch.health->note_suspect(
      static_cast<int>(key_point_of(channel, of.corrector)), misfit.misfit_K, misfit.deviation_K);
  if (verdict.failed < 0 && verdict.opened < 0) return false;
  leave_out(channel, of);
  if (verdict.opened >= 0) open_offset(channel, of);
  return true;
}

/// Takes the update into the opinion that is pending. Whether the estimator has gone over to it.
bool heed_opinion(bool loosened, const Watched& of) {
  correction::SecondOpinion& opinion = *of.watch.opinion;
  opinion.update(of.estimator);
  if (opinion.sensor() < 0) return false;
  const correction::HealthState state = of.watch.health->record(key_point_of(opinion.sensor(), of.corrector)).state;
  const bool out = state == correction::HealthState::failed || state == correction::HealthState::returning;
  const correction::Opinion concluded = opinion.conclude(loosened, of.watch.health->limits());
  if (concluded == correction::Opinion::against_model) of.estimator.note_change();
  const bool over = concluded == correction::Opinion::against_model || concluded == correction::Opinion::undecided;
  if (out || over) opinion.drop();
  return !out && concluded == correction::Opinion::against_sensor && leave_suspect_out(of);
}

/// What the filters without a sensor were sure of goes with what the estimator was sure of. If a sensor was the reason,
/// it is the one with most evidence by then; not while the priors settle.
void heed_loosening(const Watched& of) {
  SensorWatch& watch = of.watch;
  const correction::HealthLimits& limits = watch.health->limits();
  const bool settled = of.estimator.age_s() > limits.settle_s && watch.opinion->sensor() < 0;
  const Eigen::Index suspect = settled ? watch.others->most_doubtful(limits.swap_evidence) : -1;
  if (suspect >= 0) watch.opinion->begin(suspect, *watch.others);
  watch.others->follow_loosened(of.estimator);
  if (watch.heat) watch.heat->follow(of.estimator);
  const bool swapped = watch.health->note_contradiction().partner >= 0;
  watch.health->note_restart();
  if (swapped) leave_pair_out(false, of);
}

correction::HealthVerdict verdict_of(const Watched& of) {
  SensorWatch& watch = of.watch;
  std::fill(watch.samples.updates.begin(), watch.samples.updates.end(), correction::HealthUpdate{});
  for (std::size_t c = 0; c < of.corrector.channels.size(); ++c) {
    const auto channel = static_cast<Eigen::Index>(c);
    const correction::SensorRecord& record = of.estimator.record(channel);
    const correction::Misfit& misfit = watch.others->misfit(channel);
    const bool is_unlikely_without = misfit.evidence > watch.health->limits().drift_limit &&
                                     is_unlikely_machine(of.estimator.parameters(), watch.others->without(channel));
    watch.samples.updates[of.corrector.channels[c].key_point] = {record.fused || record.rejected,
                                                                 misfit.evidence,
                                                                 record.rejected_in_a_row,
                                                                 record.observation_K,
                                                                 misfit.misfit_K,
                                                                 misfit.deviation_K,
                                                                 is_unlikely_without};
  }
  return watch.health->note_update(watch.samples.updates, of.estimator.consistency().in_doubt());
}

void heed(const correction::HealthVerdict& verdict, const Watched& of) {
  SensorWatch& watch = of.watch;
  if (verdict.loosen) {
    const Eigen::Index suspect = channel_at(of.corrector, static_cast<std::size_t>(verdict.suspect));
    of.estimator.note_contradiction();
    watch.opinion->begin(suspect, *watch.others);
  }
  if (verdict.opened >= 0) {
    const Eigen::Index opened = channel_at(of.corrector, static_cast<std::size_t>(verdict.opened));
    if (watch.opinion->sensor() == opened) leave_out(opened, of);
    watch.opinion->drop();
    open_offset(opened, of);
  }
  if (verdict.failed < 0) return;
  if (verdict.partner >= 0) {
    leave_pair_out(verdict.over_gap, of);
    return;
  }
  leave_out(channel_at(of.corrector, static_cast<std::size_t>(verdict.failed)), of);
}

}  // namespace

void watch_anew(const correction::EstimatorCorrection& estimator, SensorWatch& watch) {
  if (watch.others) watch.others->follow(estimator);
  if (watch.opinion) watch.opinion->drop();
  if (watch.heat) watch.heat->follow(estimator);
}

void watch_update(const rom::Network& network, const rom::OperatingState& operating, Model& model, SensorWatch& watch,
                  Corrector& corrector) {
  note_corrected(network, model, watch);
  if (!watch.others) return;
  correction::EstimatorCorrection& estimator = *corrector.estimator;
  const Watched of{network, operating, model, watch, corrector, estimator};
  if (corrector.enabled && !watch.seen.was_enabled) watch_anew(estimator, watch);
  if (corrector.enabled != watch.seen.was_enabled) watch.health->note_restart();
  watch.seen.was_enabled = corrector.enabled;
  if (!corrector.enabled || estimator.updates() == watch.seen.updates) return;
  watch.seen.updates = estimator.updates();
  const bool loosened = estimator.loosened() != watch.seen.loosened;
  const bool relinearised = estimator.relinearised() != watch.seen.relinearised;
  watch.seen.loosened = estimator.loosened();
  if (!loosened) watch.seen.relinearised = estimator.relinearised();
  if (heed_opinion(loosened, of)) return;
  if (loosened) {
    heed_loosening(of);
    return;
  }
  if (relinearised) {
    // Beside an estimate that is suddenly surer, filters as they were would look like the better ones.
    follow_estimator(estimator, watch);
    return;
  }
  watch.others->update(estimator);
  if (explained_by_heat(of)) return;
  const correction::HealthVerdict verdict = verdict_of(of);
  Eigen::MatrixXd& alternatives = watch.others->alternatives(estimator);
  watch.opinion->put_alternative(estimator, alternatives);
  estimator.set_alternatives(alternatives);
  heed(verdict, of);
}

}  // namespace spindle_twin::firmware

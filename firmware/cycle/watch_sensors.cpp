#include "firmware/cycle/watch_sensors.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::firmware {
namespace {

static_assert(bits(SensorState::returning) == bits(correction::HealthState::returning));
static_assert(bits(TareWait::sensors) == bits(correction::TareWait::sensors));
static_assert(bits(SensorFault::implausible) == bits(correction::HealthFault::implausible));

constexpr std::size_t kept_of_a_sensor = 4;  ///< numbers
constexpr std::size_t kept_of_a_course = 2;
constexpr double read_for_partner = 2.0;  ///< the second: out until acknowledged, and read for the partner's place

/// Of the reading as it came in: the tare, and what the estimator has learnt besides.
double known_offset_K(const SensorWatch& watch, const Corrector& corrector, std::size_t key_point) {
  const Eigen::Index channel = watch.others ? channel_at(corrector, key_point) : -1;
  if (channel < 0) return watch.tare.offset_K[key_point];
  const correction::EstimatorCorrection& estimator = *corrector.estimator;
  return watch.tare.offset_K[key_point] + estimator.filter().mean()[estimator.parameters().count() + channel];
}

/// Each reading beside what the model says of it.
void sample(const WatchInputs& inputs, const Corrector& corrector, const Judgement& judgement, SensorWatch& watch) {
  const bool has_run = inputs.period.start_s > 0.0;
  for (std::size_t k = 0; k < watch.samples.health.size(); ++k) {
    const Sensed& reading = inputs.sensed.sensors[k];
    const auto row = static_cast<Eigen::Index>(k);
    const double predicted_K = inputs.model.outputs.key_points_K[row];
    // A reading out of range is the health's business too: it tells a broken wire from a hot place.
    const bool readable =
        judgement.sensors[k] == SensorQuality::good || judgement.sensors[k] == SensorQuality::out_of_range;
    // As read: a tare, which moves what is used of all sensors at once, is no jump.
    watch.samples.health[k] = {
        readable && reading.time_ns != watch.seen.time_ns[k],
        inputs.sensed.raw_K[k],
        predicted_K,
        has_run ? predicted_K - watch.samples.corrected_K[k] : 0.0,
        inputs.plan.compare_uncorrected ? inputs.uncorrected.outputs.key_points_K[row] : not_a_value,
        known_offset_K(watch, corrector, k)};
  }
}

/// A sensor that is not believed loses its quality `good`, until a new reading is.
void withhold(std::size_t k, const SensedInputs& sensed, SensorWatch& watch, Judgement& judgement) {
  const correction::HealthRecord& record = watch.health->record(k);
  if (watch.samples.health[k].present) {
    watch.seen.time_ns[k] = sensed.sensors[k].time_ns;
    watch.seen.believed[k] = record.usable;
  }
  const bool failed = record.state == correction::HealthState::failed;
  if (judgement.sensors[k] != SensorQuality::good || (watch.seen.believed[k] && !failed)) return;
  judgement.sensors[k] = SensorQuality::withheld;
  --judgement.good;
}

void widen_offset(Eigen::Index channel, double deviation_K, SensorWatch& watch, Corrector& corrector) {
  corrector.estimator->widen_offset(channel, deviation_K);
  watch.others->widen_offset(*corrector.estimator, channel, deviation_K);
  watch.opinion->widen_offset(*corrector.estimator, channel, deviation_K);
  if (watch.heat) watch.heat->follow(*corrector.estimator);
}

/// A sensor that has just returned may come back with another offset.
void widen_returned(std::size_t k, SensorWatch& watch, Corrector& corrector) {
  const correction::HealthRecord& record = watch.health->record(k);
  const Eigen::Index channel = record.returned && watch.others ? channel_at(corrector, k) : -1;
  if (channel >= 0) widen_offset(channel, record.return_offset_deviation_K, watch, corrector);
}

/// Of two that are swapped, each may be read for the other's place, which has another sensor's offset then.
void note_readers(SensorWatch& watch, Corrector& corrector) {
  for (std::size_t c = 0; watch.others && c < corrector.channels.size(); ++c) {
    CorrectorChannel& channel = corrector.channels[c];
    const std::size_t reader = watch.health->reader_of(channel.key_point);
    const bool is_own = reader == channel.key_point;
    if (reader != channel.reader && !is_own) {
      const auto of_reader = static_cast<std::size_t>(channel_at(corrector, reader));
      const double deviation_K = corrector.estimator->sensors()[of_reader].offset_deviation_K;
      widen_offset(static_cast<Eigen::Index>(c), deviation_K, watch, corrector);
    }
    channel.reader = reader;
    channel.reads = !is_own && watch.health->record(reader).read_for_partner;
  }
}

void rest(const WatchInputs& inputs, const Judgement& judgement, SensorWatch& watch) {
  constexpr double turning_rpm = 1.0;
  constexpr double loaded = 0.01;
  for (std::size_t k = 0; k < watch.samples.tare.size(); ++k) {
    const bool good = inputs.plan.sensors[k].configured && judgement.sensors[k] == SensorQuality::good;
    watch.samples.tare[k] = {good, inputs.sensed.sensors[k].value + watch.tare.offset_K[k],
                             inputs.model.outputs.key_points_K[static_cast<Eigen::Index>(k)]};
  }
  const bool heated = std::abs(judgement.signals[static_cast<std::size_t>(Signal::speed)]) > turning_rpm ||
                      std::abs(judgement.signals[static_cast<std::size_t>(Signal::load)]) > loaded;
  watch.resting->step(watch.samples.tare, heated, inputs.period.advance_s);
}

/// The estimator's offsets are of readings less the tare.
void tell_estimator(const std::array<double, slots::key_points>& before_K, const CyclePlan& plan, SensorWatch& watch,
                    Corrector& corrector) {
  if (!corrector.estimator) return;
  for (std::size_t c = 0; c < corrector.channels.size(); ++c) {
    const std::size_t k = corrector.channels[c].key_point;
    const auto channel = static_cast<Eigen::Index>(c);
    const double shift_K = watch.tare.offset_K[k] - before_K[k];
    // Without a tare the offset is as open as the configuration says.
    const double deviation_K =
        watch.tare.deviation_K[k] > 0.0 ? watch.tare.deviation_K[k] : plan.sensors[k].offset_deviation_K;
    corrector.estimator->note_tare(channel, shift_K, deviation_K);
    if (watch.others) watch.others->shift_offset(*corrector.estimator, channel, shift_K);
    if (watch.opinion) watch.opinion->shift_offset(*corrector.estimator, channel, shift_K);
    if (watch.heat) watch.heat->follow(*corrector.estimator);
  }
}

}  // namespace

Eigen::Index channel_at(const Corrector& corrector, std::size_t key_point) {
  for (std::size_t c = 0; c < corrector.channels.size(); ++c) {
    if (corrector.channels[c].key_point == key_point) return static_cast<Eigen::Index>(c);
  }
  return -1;
}

void note_corrected(const rom::Network& network, const Model& model, SensorWatch& watch) {
  for (std::size_t k = 0; k < watch.samples.corrected_K.size(); ++k) {
    watch.samples.corrected_K[k] = network.key_points[k].row.dot(model.stepper->temperatures_K());
  }
}

SensorWatch make_watch(const rom::Network& network, const CyclePlan& plan, const Corrector& corrector) {
  SensorWatch watch;
  watch.tare_to_ambient = plan.tare_to_ambient;
  const std::size_t count = network.key_points.size();
  watch.resting.emplace(count, plan.tare);
  watch.samples.tare.resize(count);
  watch.tare.offset_K.assign(count, 0.0);
  watch.tare.deviation_K.assign(count, 0.0);
  watch.samples.corrected_K.assign(count, 0.0);
  if (!plan.health) return watch;
  std::vector<correction::HealthChannel> channels;
  for (std::size_t k = 0; k < count; ++k) {
    const SensorPlan& sensor = plan.sensors[k];
    channels.push_back({sensor.configured, sensor.min_K, sensor.max_K, sensor.resolution_K, sensor.noise_K,
                        std::max(sensor.interval_s, plan.period_s), sensor.lag_s});
  }
  correction::HealthLimits limits = *plan.health;
  // Only an estimator learns an offset anew.
  if (corrector.corrects && corrector.estimator) {
    watch.others.emplace(*corrector.estimator);
    watch.opinion.emplace(*corrector.estimator);
    if (corrector.estimator->parameters().has_disturbances() && !corrector.estimator->heats_are_open()) {
      watch.heat.emplace(*corrector.estimator);
    }
  } else {
    limits.return_within_K = plan.return_within_K;
  }
  watch.health.emplace(std::move(channels), limits);
  watch.samples.health.resize(count);
  watch.samples.updates.resize(count);
  watch.seen.believed.fill(true);
  return watch;
}

void subtract_tare(const SensorWatch& watch, SensedInputs& sensed) {
  for (std::size_t k = 0; k < sensed.sensors.size(); ++k) sensed.raw_K[k] = sensed.sensors[k].value;
  for (std::size_t k = 0; k < watch.tare.offset_K.size(); ++k) sensed.sensors[k].value -= watch.tare.offset_K[k];
}

void watch_sensors(const WatchInputs& inputs, SensorWatch& watch, Corrector& corrector, Judgement& judgement) {
  const Period& period = inputs.period;
  if (watch.health) {
    sample(inputs, corrector, judgement, watch);
    watch.health->step(watch.samples.health, period.start_s, period.start_s > 0.0 ? period.advance_s : 0.0);
    for (std::size_t k = 0; k < watch.samples.health.size(); ++k) {
      withhold(k, inputs.sensed, watch, judgement);
      widen_returned(k, watch, corrector);
    }
    note_readers(watch, corrector);
  }
  rest(inputs, judgement, watch);
  note_corrected(inputs.network, inputs.model, watch);
}

void watch_gap(const WatchInputs& inputs, SensorWatch& watch, Corrector& corrector, const Judgement& judgement) {
  if (watch.health) {
    sample(inputs, corrector, judgement, watch);
    watch.health->step(watch.samples.health, inputs.period.start_s, inputs.period.advance_s);
    note_readers(watch, corrector);
  }
  note_corrected(inputs.network, inputs.model, watch);
}

bool take_sensor_order(SensorOrder order, const CyclePlan& plan, const Judgement& judgement, SensorWatch& watch,
                       Corrector& corrector) {
  if (order == SensorOrder::acknowledge) {
    if (watch.health) watch.health->acknowledge();
    return true;
  }
  double noise_K = 0.0;
  for (const SensorPlan& sensor : plan.sensors) noise_K = std::max(noise_K, sensor.configured ? sensor.noise_K : 0.0);
  std::array<double, slots::key_points> before_K{};
  std::copy(watch.tare.offset_K.begin(), watch.tare.offset_K.end(), before_K.begin());
  if (order == SensorOrder::tare) {
    const double ambient_K =
        watch.tare_to_ambient ? judgement.signals[static_cast<std::size_t>(Signal::ambient)] : not_a_value;
    if (!watch.resting->take(ambient_K, noise_K, watch.tare)) return false;
  } else {
    correction::IsothermalTare::clear(watch.tare);
  }
  tell_estimator(before_K, plan, watch, corrector);
  return true;
}

void set_tare(const correction::SensorTare& tare, const CyclePlan& plan, SensorWatch& watch, Corrector& corrector) {
  std::array<double, slots::key_points> before_K{};
  std::copy(watch.tare.offset_K.begin(), watch.tare.offset_K.end(), before_K.begin());
  const bool same = watch.tare.offset_K == tare.offset_K && watch.tare.deviation_K == tare.deviation_K;
  watch.tare = tare;
  if (!same) tell_estimator(before_K, plan, watch, corrector);
}

void keep_health(const SensorWatch& watch, Remembered& to) {
  if (!watch.health) return;
  to.sensor_health.resize(kept_of_a_sensor * watch.health->count());
  to.sensor_course.resize(kept_of_a_course * watch.health->count());
  for (std::size_t k = 0; k < watch.health->count(); ++k) {
    const correction::KeptHealth kept = watch.health->kept(k);
    double* of = to.sensor_health.data() + kept_of_a_sensor * k;
    of[0] = static_cast<double>(kept.fault);
    of[1] = kept.read_for_partner ? read_for_partner : kept.latched ? 1.0 : 0.0;
    of[2] = kept.partner;
    of[3] = kept.failures;
    double* course = to.sensor_course.data() + kept_of_a_course * k;
    course[0] = kept.usual_offset_K;
    course[1] = kept.used_before_s;
  }
}

void resume_health(const Remembered& remembered, double away_s, SensorWatch& watch) {
  const std::vector<double>& from = remembered.sensor_health;
  if (!watch.health || from.size() != kept_of_a_sensor * watch.health->count()) return;
  const auto sensors = static_cast<double>(watch.health->count());
  const auto is_kept = [&](const double* of) {
    constexpr double most_failures = 1e6;
    return of[0] >= 0.0 && of[0] <= bits(SensorFault::implausible) && of[2] >= -1.0 && of[2] < sensors &&
           of[3] >= 0.0 && of[3] <= most_failures;
  };
  for (std::size_t at = 0; at < from.size(); at += kept_of_a_sensor) {
    if (!is_kept(from.data() + at)) return;
  }
  for (std::size_t k = 0; k < watch.health->count(); ++k) {
    const double* of = from.data() + kept_of_a_sensor * k;
    correction::KeptHealth kept{static_cast<correction::HealthFault>(of[0]), of[1] != 0.0, static_cast<int>(of[2]),
                                static_cast<int>(of[3]), of[1] == read_for_partner};
    if (remembered.sensor_course.size() == kept_of_a_course * watch.health->count()) {
      const double* course = remembered.sensor_course.data() + kept_of_a_course * k;
      if (course[1] >= 0.0) kept.usual_offset_K = course[0];
      kept.used_before_s = course[1];
    }
    watch.health->resume(k, kept, away_s);
  }
}

void publish_health(const SensorWatch& watch, const Corrector& corrector, Snapshot& snapshot) {
  snapshot.sensor_tare_count = static_cast<std::uint16_t>(watch.tare.count);
  if (watch.resting->offered()) snapshot.quality |= bits(Quality::sensor_tare_offered);
  const correction::TareOutlook tare = watch.resting->outlook();
  snapshot.sensor_tare_wait = static_cast<TareWait>(tare.waits_for);
  snapshot.sensor_tare_point = static_cast<std::int16_t>(tare.channel);
  snapshot.sensor_tare_left_s = tare.left_s;
  for (std::size_t k = 0; k < watch.tare.offset_K.size(); ++k) {
    if (snapshot.sensor_quality[k] != SensorQuality::not_configured) snapshot.sensor_tare_K[k] = watch.tare.offset_K[k];
  }
  snapshot.sensors_failed = 0;
  if (!watch.health) return;
  snapshot.health_watched = true;
  snapshot.model_in_doubt = watch.health->model_in_doubt();
  for (std::size_t k = 0; k < watch.samples.health.size(); ++k) {
    if (snapshot.sensor_quality[k] == SensorQuality::not_configured) continue;
    const correction::HealthRecord& record = watch.health->record(k);
    SensorHealthState& to = snapshot.sensor_health[k];
    to.state = static_cast<SensorState>(record.state);
    to.fault = static_cast<SensorFault>(record.fault);
    to.partner = static_cast<std::int16_t>(record.partner);
    to.spikes = static_cast<std::uint16_t>(std::min(record.spikes, 65534));
    const Eigen::Index channel = watch.others ? channel_at(corrector, k) : -1;
    const bool judged = channel >= 0 && watch.others->misfit(channel).judged;
    to.misfit_ratio = judged ? watch.others->misfit(channel).ratio() : not_a_value;
    const bool out =
        record.state == correction::HealthState::failed || record.state == correction::HealthState::returning;
    if (out) ++snapshot.sensors_failed;
  }
  snapshot.model_in_doubt = snapshot.model_in_doubt || is_estimate_in_doubt(corrector);
  if (snapshot.sensors_failed > 0) snapshot.quality |= bits(Quality::sensor_failed);
}

}  // namespace spindle_twin::firmware

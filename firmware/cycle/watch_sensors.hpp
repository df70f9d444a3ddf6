#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "correction/health/isothermal_tare.hpp"
#include "correction/health/leave_one_out.hpp"
#include "correction/health/second_opinion.hpp"
#include "correction/health/sensor_health.hpp"
#include "correction/health/unexplained_heat.hpp"
#include "firmware/cycle/correct.hpp"
#include "firmware/cycle/remember.hpp"

namespace spindle_twin::firmware {

/// What was seen when the sensors were judged last.
struct SensorsSeen {
  std::array<std::int64_t, slots::key_points> time_ns{};  ///< of the reading
  std::array<bool, slots::key_points> believed{};         ///< what was made of it
  long updates = 0;                                       ///< of the estimator
  long loosened = 0;
  long relinearised = 0;
  bool heats_were_open = false;
  bool was_enabled = false;
};

/// Filled anew in each cycle; kept so that no cycle allocates. One entry per key point.
struct SensorSamples {
  std::vector<correction::HealthSample> health;
  std::vector<correction::HealthUpdate> updates;
  std::vector<correction::TareSample> tare;
  std::vector<double> corrected_K;  ///< of the model, after the last correction
};

/// Health of the sensors at the key points, and their tare.
struct SensorWatch {
  std::optional<correction::SensorHealth> health;    ///< empty: not asked for
  std::optional<correction::LeaveOneOut> others;     ///< with an estimator that corrects
  std::optional<correction::SecondOpinion> opinion;  ///< likewise
  std::optional<correction::UnexplainedHeat> heat;   ///< likewise, where the network is certified
  std::optional<correction::IsothermalTare> resting;
  correction::SensorTare tare;
  bool tare_to_ambient = false;
  SensorSamples samples;
  SensorsSeen seen;
  std::uint32_t orders = 0;
};

/// What readings are judged by.
struct WatchInputs {
  const rom::Network& network;
  const CyclePlan& plan;
  const SensedInputs& sensed;
  const Model& model;
  const Model& uncorrected;
  const Period& period;
};

/// Allocates. Throws rom::InputError for a limit out of range.
SensorWatch make_watch(const rom::Network& network, const CyclePlan& plan, const Corrector& corrector);

/// The channel of the estimator at a key point, -1 without one. Runs in the cycle.
Eigen::Index channel_at(const Corrector& corrector, std::size_t key_point);

/// What the model says of each key point after its last correction. Runs in the cycle.
void note_corrected(const rom::Network& network, const Model& model, SensorWatch& watch);

/// The estimator was reset or resumed: all filters beside it begin anew from it, and no opinion on a sensor is pending.
/// Runs in the cycle.
void watch_anew(const correction::EstimatorCorrection& estimator, SensorWatch& watch);

/// Subtracts the tare from the readings. Runs in the cycle.
void subtract_tare(const SensorWatch& watch, SensedInputs& sensed);

/// Each new reading against its own course and the model, before it corrects anything: a sensor that is not believed
/// loses its quality `good`. A repeat of a reading is as good as that was. Runs in the cycle, once the model runs.
void watch_sensors(const WatchInputs& inputs, SensorWatch& watch, Corrector& corrector, Judgement& judgement);

/// Time in which nobody looked at a sensor, none of which is `good` in the judgement: what the model moved in it
/// belongs to each sensor's course. Runs in the cycle, once the model runs.
void watch_gap(const WatchInputs& inputs, SensorWatch& watch, Corrector& corrector, const Judgement& judgement);

/// After correct(): what the update said of each sensor. The estimator goes over to the filter without a sensor that
/// failed by it, which changes the model's state. Runs in the cycle.
void watch_update(const rom::Network& network, const rom::OperatingState& operating, Model& model, SensorWatch& watch,
                  Corrector& corrector);

/// An order from the PLC; false where a tare is not offered. Runs in the cycle.
bool take_sensor_order(SensorOrder order, const CyclePlan& plan, const Judgement& judgement, SensorWatch& watch,
                       Corrector& corrector);

/// Another tare from now on; the estimator is told of the difference. As long as what a network has of key points.
/// Runs in the cycle.
void set_tare(const correction::SensorTare& tare, const CyclePlan& plan, SensorWatch& watch, Corrector& corrector);

/// What of the sensors' health outlives a restart: sensor_health and sensor_course, which the first call sizes.
void keep_health(const SensorWatch& watch, Remembered& to);

/// Before the first step, away_s >= 0 after that was kept: sensors that were out are out, and their courses of before
/// are known. Does nothing where `from` has none that keep_health() wrote of as many key points.
void resume_health(const Remembered& from, double away_s, SensorWatch& watch);

/// Into the snapshot, and the quality bits. Runs in the cycle.
void publish_health(const SensorWatch& watch, const Corrector& corrector, Snapshot& snapshot);

}  // namespace spindle_twin::firmware

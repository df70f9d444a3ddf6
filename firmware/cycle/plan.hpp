#pragma once

#include <array>
#include <limits>
#include <optional>

#include "correction/calibration/calibration.hpp"
#include "correction/estimator/estimator_correction.hpp"
#include "correction/health/isothermal_tare.hpp"
#include "correction/health/limits.hpp"
#include "correction/paper/paper_correction.hpp"
#include "firmware/cycle/compensate.hpp"
#include "firmware/cycle/forecast.hpp"
#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

/// The sensor at one key point, when its reading is believed, and what the estimator assumes of it.
struct SensorPlan {
  bool configured = false;
  double min_K = 253.15;
  double max_K = 423.15;
  double stale_after_s = 3.0;        ///< model time
  double noise_K = 0.03;             ///< 1σ of one reading
  double offset_deviation_K = 0.02;  ///< 1σ of its constant error
  double lag_s = 0.0;                ///< first-order lag, model time
  double interval_s = 0.0;           ///< the device renews it so often, readings in between are repeats; 0: each is new
  double resolution_K = 0.01;        ///< smallest step of the reading
};

/// A displacement probe at one deformation output. It counts as the published value does: of the nose minus the tare.
struct ProbePlan {
  bool configured = false;
  double deviation_m = 1e-6;
  double min_m = -1e-3;  ///< a reading outside is not used
  double max_m = 1e-3;
  double interval_s = 60.0;    ///< between readings that are taken in
  double stale_after_s = 3.0;  ///< model time
};

enum class SignalSource { none, constant, device, plc };

struct SignalPlan {
  SignalSource source = SignalSource::none;
  double value = not_a_value;  ///< of a constant; else what is used until the first good reading. NaN: not known
  double min = std::numeric_limits<double>::lowest();  ///< believed range
  double max = std::numeric_limits<double>::max();
  double stale_after_s = 0.0;  ///< model time; 0: never, for a PLC that writes on change only
  double most_per_s = std::numeric_limits<double>::infinity();  ///< a change is believed once it could be so fast
};

/// What a cycle needs besides the network; made once from the configuration.
struct CyclePlan {          // NOLINT(public-members): the configuration of the cycle, made once, then constant
  double period_s = 1.0;    ///< model time
  double clock_rate = 1.0;  ///< model seconds per second of the clock
  bool compare_uncorrected = true;
  std::array<SensorPlan, slots::key_points> sensors;
  std::array<ProbePlan, slots::deformations> probes;
  std::array<SignalPlan, signal_count> signals;   ///< from first_optional_signal on some machines tell none
  bool correction_enabled = true;                 ///< until the PLC says otherwise
  std::optional<correction::PaperOptions> paper;  ///< the published law corrects
  /// The estimator, without sensors: these come from `sensors`. Not together with `paper`.
  std::optional<correction::EstimatorOptions> estimator;
  correction::DriftOptions drift;  ///< what the machine may have changed by in a long absence, and since a calibration
  bool estimator_corrects = true;  ///< false: it stands by for ever and only says how sure the open loop is
  std::optional<correction::HealthLimits> health =
      correction::HealthLimits{};  ///< empty: sensors are only judged by range and age
  double return_within_K = 0.5;    ///< of its old course, for a failed sensor to return where no estimator corrects
  correction::TareLimits tare;
  bool tare_to_ambient = false;  ///< else to the common mean of the sensors
  double plc_timeout_s = 0.0;    ///< clock time; a PLC that is silent for longer tells nothing any more. 0: for ever
  /// Published deformations stay within plus and minus this, by deformation output.
  std::array<double, slots::deformations> output_limit_m = [] {
    std::array<double, slots::deformations> limits{};
    limits.fill(std::numeric_limits<double>::infinity());
    return limits;
  }();
  double slew_m_per_s = 5e-7;  ///< published deformations follow the prediction no faster, model time
  CompensationPlan compensation;
  ForecastPlan forecast;
  std::optional<double> start_temperature_K;  ///< empty: mean of the first good readings
  Eigen::VectorXd start_nodes_K;              ///< one per node, in place of start_temperature_K; or empty
  double start_wait_s = 60.0;                 ///< model time until fewer sensors must do, or a fault is raised
};

}  // namespace spindle_twin::firmware

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "correction/calibrate/calibrate.hpp"
#include "fem_offline/model/affine_model.hpp"
#include "rom/network.hpp"
#include "tests/bench/campaign/campaign.hpp"

/// Virtual spindles that get a thermal test with a displacement probe, and are followed on other days.
namespace spindle_twin::bench {

/// How much a machine has changed between test and service, 1σ of ln factors.
struct Drifted {
  const char* name;
  double heat, contact, film;
};
inline constexpr std::array<Drifted, 2> drifts{{{"5/10/5 %", 0.05, 0.10, 0.05}, {"15/30/15 %", 0.15, 0.30, 0.15}}};
inline constexpr std::array<int, 2> permanent_sensors{3, 6};

/// One day of service of one machine with one set of sensors.
struct Service {
  double uncorrected_um = 0.0;  ///< neither test nor sensors
  double span_um = 0.0;
  std::array<Score, permanent_sensors.size()> without_test{}, with_test{}, blind{};
  std::array<double, permanent_sensors.size()> bound_um{};  ///< of the filter with the calibration, linear
};

/// A machine: its tests' fits, and a day with each drift.
struct Commissioned {
  std::uint64_t seed = 0;
  HeatErrors heats = HeatErrors::independent;
  std::array<int, permanent_sensors.size()> evaluations{};
  std::array<double, permanent_sensors.size()> fit_s{};        ///< wall clock
  std::array<double, permanent_sensors.size()> probe_um{};     ///< rms of what the fit leaves of the probe
  std::array<double, permanent_sensors.size()> hold_out_um{};  ///< rms of the probe in the last quarter, predicted
  std::array<double, permanent_sensors.size()> chi_square{};
  std::array<bool, permanent_sensors.size()> refused{};  ///< by the limits of calibrate
  std::array<correction::Calibration, permanent_sensors.size()> calibrations;
  std::array<std::vector<correction::StartedFit>, permanent_sensors.size()> starts;
  std::array<std::vector<double>, permanent_sensors.size()> off;  ///< of each parameter in its deviations
  std::array<Service, drifts.size()> days;
};

struct TestPlan {
  double test_s = 7200.0;
  double service_s = 14400.0;
  double expansion = 0.05;  ///< 1σ of ln of how much more a machine expands than the twin believes
  bool touch_offs = false;  ///< each half hour instead of a probe
};

inline constexpr std::uint64_t day_stream = 8'000'000;  ///< added to a machine's seed: its days of service

/// Of the test: 6000, 12000 and 3000 rpm, a third each; sensors that lag 5 s, told.
Conditions conditions_of_test(const TestPlan& plan);
/// Of a day of service of the machine with these hidden parameters.
Conditions conditions_of_day(const TestPlan& plan, const Eigen::VectorXd& theta);

/// What the first `sensors` sensors and a probe at the nose, of unknown zero and drifting, say in a test.
correction::ThermalTest log_of(const rom::Network& network, const Truth& truth, int sensors, const TestPlan& plan);

/// For `calibrate`: priors and places of the first `sensors` sensors.
correction::CalibrateOptions calibrate_options(const rom::Network& network, int sensors, HeatErrors heats);

/// Hidden parameters of the machine on another day.
Eigen::VectorXd drifted(const correction::ParameterModel& parameters, const Eigen::VectorXd& theta, const Drifted& by,
                        std::uint64_t seed);

/// rms of the probe among channels of a fit with that many sensors. [um]
double probe_rms_um(const std::vector<correction::ChannelFit>& channels, std::size_t sensors);

Commissioned commission(const rom::Network& network, const fem_offline::AffineModel& truth_model, std::uint64_t seed,
                        HeatErrors heats, const TestPlan& plan);

}  // namespace spindle_twin::bench

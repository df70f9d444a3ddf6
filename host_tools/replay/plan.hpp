#pragma once

#include <optional>
#include <string>
#include <vector>

#include "firmware/config/config.hpp"
#include "host_tools/replay/log.hpp"

namespace spindle_twin::host_tools {

/// How a log is to be run.
struct ReplayOptions {               // NOLINT(public-members): what a command line may say, a member each
  std::string network;               ///< the file's path, for messages
  std::string correction;            ///< none, paper, estimator; empty: as the configuration or its default says
  std::string config;                ///< of the daemon; its sensors, ranges, periods and options count. Empty: none
  std::vector<std::string> sensors;  ///< key points that the correction is given, without a configuration; empty: all
  std::optional<double> period_s;    ///< without a configuration; else a history's own, else 1 s
  std::optional<double> start_degC;  ///< of the whole spindle; else the configuration's, else the sensors' mean
  double longest_gap_s = 60.0;       ///< between two rows of a plain log
  // Without a configuration, and of the estimator; empty: its defaults.
  std::optional<double> floor_K;             ///< correlated error of the model at a sensor, 1σ
  std::optional<double> offset_deviation_K;  ///< constant error of each sensor, 1σ
  std::optional<double> lag_s;               ///< first-order lag of each sensor
  std::optional<double> start_K;             ///< how sure the start temperature is, 1σ
  std::string health;                        ///< on, off; empty: on
  std::string calibration;                   ///< file that the estimator begins with; empty: none
};

/// The plan that the daemon would run, made by the same steps. Without a configuration: every sensor that the log has,
/// at the limits of a configuration's defaults, a reading counting as long as longest_gap_s; signals as the log has
/// them, else at the network's operating state. Throws rom::InputError, as firmware::read_config and bind_config do,
/// for a configured sensor that the log lacks, for a correction without a sensor, for a start without a temperature,
/// and for options of the estimator where the published law corrects.
firmware::CyclePlan plan_replay(const rom::Network& network, const Log& log, const ReplayOptions& options);

/// none, paper or estimator.
const char* law_of(const firmware::CyclePlan& plan);

}  // namespace spindle_twin::host_tools

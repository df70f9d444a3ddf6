#pragma once

#include <optional>
#include <string>
#include <vector>

#include "correction/calibration/calibration.hpp"
#include "firmware/acquire/driver.hpp"
#include "firmware/config/listeners.hpp"
#include "firmware/config/read_devices.hpp"
#include "firmware/cycle/plan.hpp"
#include "firmware/cycle/trial_score.hpp"
#include "firmware/keep/keep_plan.hpp"
#include "firmware/plant/plant_plan.hpp"
#include "firmware/serve/serve_plan.hpp"
#include "firmware/show/show_plan.hpp"
#include "rom/file/keys.hpp"
#include "rom/network.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {

struct ConfiguredSensor {
  std::string key_point;
  rom::SourceLine where;
  std::string field;
  std::optional<ConfiguredChannel> channel;  ///< empty: of a log, which has it in degC
  double min_degC = -20.0;
  double max_degC = 150.0;
  double stale_after_s = 3.0;
  std::optional<double> noise_K;  ///< empty: as [correction] says of all sensors
  std::optional<double> offset_deviation_K;
  std::optional<double> lag_s;
  double interval_s = 0.0;
  std::optional<double> resolution_K;  ///< empty: one count of an integer register, 0.01 K of a float
};

/// A displacement probe.
struct ConfiguredProbe {
  std::string output;
  rom::SourceLine where;
  std::string field;
  ConfiguredChannel channel;
  ProbePlan plan;
};

struct ConfiguredSignal {
  rom::SourceLine where;
  std::string field;
  SignalPlan plan;            ///< in K, rpm, fraction, A, W, kg/s, W; the widest limits there are
  std::optional<double> min;  ///< likewise; empty: as the network suggests
  std::optional<double> max;
  std::optional<double> most_per_s;
  std::optional<ConfiguredChannel> channel;  ///< of a device signal
  bool has_first = false;                    ///< the configuration says what is used until the first good reading
};

/// The flow of one coolant circuit; without a first value the network's operating flow is used until it is read.
struct ConfiguredFlow {
  std::string circuit;
  ConfiguredSignal signal;
};

/// The watts of one measured heat; without a first value its law counts until it is read.
struct ConfiguredHeat {
  std::string heat;
  ConfiguredSignal signal;
};

/// The start temperature of one node.
struct ConfiguredStart {
  std::string node;
  double temperature_K = zero_degC_K;
  rom::SourceLine where;
  std::string field;
};

/// How far a published deformation may be from zero.
struct ConfiguredLimit {
  std::string output;  ///< empty: of all that are not named
  double limit_m = 0.0;
  rom::SourceLine where;
  std::string field;
};

struct ConfiguredGroup {
  std::string name;
  rom::SourceLine where;
  std::string field;
  std::vector<std::string> sensors;
  std::vector<std::string> sources;
};

/// Which network file is run, and what must be true of it.
struct ConfiguredNetwork {
  std::string path;  ///< relative to the configuration file's folder
  rom::SourceLine where;
  std::string field;
  bool allow_uncertified = false;  ///< a hand-written network, which cannot have a certificate
  bool require_signature = false;
  std::vector<rom::PublicKey> trusted_keys;  ///< whose signature counts
  std::vector<std::string> key_files = {};   ///< those of them that stand in files
};

/// Where new networks come in while the daemon runs, and how they are judged.
struct ConfiguredExchange {
  std::string slot;  ///< the folder; empty: none
  ExchangePlan plan;
};

/// What a commissioning test has left of the priors.
struct ConfiguredCalibration {
  std::string path;
  correction::Calibration calibration;
};

/// What of the compensation needs the network.
struct ConfiguredCompensation {
  std::string other;  ///< deformation output that the slope comes from; empty: none
  std::optional<double> limit_m, warning_m;
  rom::SourceLine where, warning_where, step_where;
};

/// The configuration file as it stands, checked as far as that goes without the network.
struct Config {  // NOLINT(public-members): the configuration as read, a member for each of its tables
  std::string path;
  ConfiguredNetwork network;
  std::string log_level = "info";
  HistoryPlan history;
  KeepPlan keep;
  ServePlan serve;
  ShowPlan show;
  PlantPlan plant;
  std::vector<DevicePlan> devices;  ///< their channels go nowhere yet
  CyclePlan cycle;                  ///< without sensors and signals that need the network
  std::vector<ConfiguredSensor> sensors;
  std::vector<ConfiguredProbe> probes;
  std::array<ConfiguredSignal, first_flow_signal> signals;
  rom::SourceLine signals_where;
  std::vector<ConfiguredFlow> flows;
  std::vector<ConfiguredHeat> heats;
  std::vector<ConfiguredGroup> groups;
  std::vector<ConfiguredStart> start;  ///< of single nodes; the others have their mean
  rom::SourceLine start_where;         ///< of the one start temperature of all, where it is given
  std::vector<ConfiguredLimit> output_limits;
  ConfiguredCompensation compensation;
  ConfiguredExchange exchange;
  std::optional<ConfiguredCalibration> calibration;
};

/// Reads and checks. Throws rom::InputError with file, line, field and what is allowed.
Config read_config(const std::string& path);

/// That of one spindle for who replays or fits its logs: a daemon's own file, or one of those that a list of spindles
/// names, which has no [serve] but for `plc_timeout_s`. Throws likewise, also for such a list itself.
Config read_spindle_config(const std::string& path);
Config parse_config(const std::string& text, const std::string& path);
/// Of one spindle among several: without what all have together, which stands in the file `list`. Its devices' ports
/// are noted in `listeners`.
Config read_config_of_one(const rom::TomlTable& root, const std::string& path, const std::string& list,
                          Listeners& listeners);

/// What the parts of one spindle are made from.
struct SpindlePlan {
  CyclePlan cycle;
  std::vector<DevicePlan> devices;
};

/// Finds the configuration's names in the network. A coolant circuit without a flow signal has its operating
/// flow for ever, a measured heat without a signal its law. Throws rom::InputError for a sensor, source, circuit, heat
/// or node that the network does not have (its message lists those it has), for a current or power that no heat of the
/// network follows, for a calibration of another spindle, for no coolant or ambient signal where the network has such a
/// surrounding, and for a network with more outputs than the register map has room for.
SpindlePlan bind_config(const Config& config, const rom::Network& network);

}  // namespace spindle_twin::firmware

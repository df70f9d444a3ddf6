#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "firmware/cycle/cycle.hpp"
#include "rom/network.hpp"

/// Random hand-written networks, machines that are other than their network says, what they do, and what goes wrong
/// with their sensors and signals. All from seeds.
namespace spindle_twin::firmware {

using Random = std::mt19937_64;

inline double draw(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline int draw_int(Random& random, int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); }
inline bool toss(Random& random, double probability) { return std::bernoulli_distribution(probability)(random); }

/// Three to ten nodes, a tree of contacts, gaps and conductions with some more of them, films to the room and perhaps
/// to water, one to three heats; read as the file that somebody wrote. Every node is a key point: "node_0" and so on.
rom::Network random_network(Random& random);

/// The same with each capacity, conductance and heat off by a factor of its own; `spread` is 1 sigma of its logarithm.
rom::Network made_other(const rom::Network& network, double spread, Random& random);

/// What the machine does and what is around it, held for lasting_s.
struct LogStep {
  double lasting_s = 0.0;
  double speed_rpm = 0.0;
  double load = 0.0;
  double ambient_K = 293.15;
  double coolant_K = 293.15;
};
std::vector<LogStep> random_log(const rom::Network& network, double end_s, Random& random);
const LogStep& at_time(const std::vector<LogStep>& log, double time_s);

/// The machine: the other network in time.
class RandomMachine {
 public:
  explicit RandomMachine(rom::Network network);
  void start(double temperature_K);
  void advance(double period_s, const LogStep& step);
  const Eigen::VectorXd& nodes_K() const { return model_.outputs.key_points_K; }

 private:
  rom::Network network_;
  Model model_;
  rom::CorrectionFactors none_;
  rom::OperatingState operating_;
};

enum class Trouble {
  jump,
  drift,
  stuck,
  exchanged,
  not_a_number,
  gap,
  spikes,
  load_absurd,
  coolant_absurd,
  ambient_absurd,
  speed_scale,
  signals_missing,
  count
};
const char* name_of(Trouble trouble);

struct TroubleEvent {
  Trouble trouble = Trouble::jump;
  double from_s = 0.0;
  double until_s = 0.0;
  std::size_t sensor = 0;   ///< key point
  std::size_t partner = 0;  ///< key point
  double size = 0.0;        ///< K, K/h or what the signal is then
};
/// One to three, anywhere between the start and end_s.
std::vector<TroubleEvent> random_troubles(const std::vector<std::size_t>& sensors, double end_s, Random& random);
std::string describe(const std::vector<TroubleEvent>& events);

/// What the device says with all of that.
class TroubledDevice {
 public:
  TroubledDevice(std::vector<std::size_t> sensors, std::vector<TroubleEvent> events, std::uint64_t seed);
  const DeviceFrame& read(const Eigen::VectorXd& nodes_K, const LogStep& step, double time_s, std::int64_t now_ns);

 private:
  void apply(const TroubleEvent& event, const Eigen::VectorXd& nodes_K, double time_s);
  Reading& signal(Signal which) { return frame_.signals[static_cast<std::size_t>(which)]; }

  std::vector<std::size_t> sensors_;
  std::vector<TroubleEvent> events_;
  Random random_;
  DeviceFrame frame_, before_;
  Eigen::VectorXd offset_K_;
};

}  // namespace spindle_twin::firmware

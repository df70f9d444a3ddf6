#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "firmware/cycle/correct.hpp"
#include "firmware/cycle/device_inbox.hpp"
#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/heat_paths.hpp"
#include "firmware/cycle/order_desk.hpp"
#include "firmware/cycle/publish.hpp"
#include "firmware/cycle/remember.hpp"
#include "firmware/cycle/troubles.hpp"
#include "firmware/cycle/watch_sensors.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/pulse.hpp"

namespace spindle_twin::firmware {

/// What was of use in what a cycle was to remember. `temperatures`: of the estimator what Cycle::begin_with_machine()
/// says at most.
/// `implausible`: nothing, because temperatures or tares are beyond what a spindle can have.
/// `given_up`: it was not waited for.
enum class Resumed { nothing, implausible, temperatures, temperatures_and_estimator, given_up };

/// The twin's own work, once per period: sense, judge, correct, integrate, predict, publish.
/// The prediction that a cycle publishes is for the end of the period that begins with it.
class Cycle {
 public:
  /// `network` must outlive this. `shared`: its operator where the steppers share one, for the estimator too; null:
  /// each has its own. Allocates. Throws rom::InputError for a correction option out of range.
  Cycle(const rom::Network& network, const CyclePlan& plan, const MakeStepper& make_stepper,
        std::shared_ptr<const rom::NetworkOperator> shared = nullptr);

  /// One cycle at now_ns after `missed` periods without one. The model first goes through these with the inputs of the
  /// cycle before, so that readings are compared with the model of now; what is published moves by one period's slew.
  /// No allocation after the first ones, no lock, no blocking call.
  const Snapshot& step(const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns, std::int64_t missed);

  /// What the last step made of its command's orders.
  const OrderResults& order_results() const { return results_; }

  /// What holds now of all orders, but for the revision. May run in the cycle.
  StandingOrders standing_orders() const;

  /// Before the first step and after resume(): orders of a run before.
  void stand_by_orders(const StandingOrders& orders);

  /// What the other threads cannot do, for the next steps. May run in the cycle.
  void note_troubles(const Troubles& troubles);

  /// What the estimator that corrects estimates; null without one.
  const correction::ParameterModel* parameters() const;

  /// Sizes `to` on the first call; from then on it may be called between two cycles.
  void remember(Remembered& to) const;

  /// Which network it runs, for the registers and what is kept: the SHA-256 of its file, hex. Before the first step.
  void identify(const std::string& network_sha256);

  /// Whose zero counts behind take_over(): the other's, moved by what the two networks say apart, so that the growth
  /// since the tare goes on from what was shown; or the cycle's own.
  enum class TareOf { other, itself };

  /// Before its first step: to run on the same inputs and orders as `running`, of another network of the same spindle.
  /// Signals, the sensors' tare and the orders obeyed are taken from it. May run in the cycle.
  void begin_beside(const Cycle& running);

  /// Between two steps: what this says is shown from now on in place of what `shown` says. Published deformations, nose
  /// and compensation go on from where they are and follow this cycle's prediction at the slew limit, each of them; the
  /// counts go on. May run in the cycle.
  void take_over(const Cycle& shown, TareOf tare_of);

  /// From now on each node starts at this temperature [K], whatever the plan says. Before the first step; allocates.
  void start_at(const Eigen::VectorXd& nodes_K) { plan_.start_nodes_K = nodes_K; }

  /// Before the first step: goes on from what was remembered gap_s of model time ago. The spindle is taken to have
  /// stood still since, with environments and flows as they were then; sensitivities and variances are carried through
  /// it, and the estimator is told what the spindle would have warmed if it had run all the time: first readings that
  /// say so find it open to that. The estimator goes on only where its parameters and sensors are the same. Nothing is
  /// changed where nothing fits. Allocates. Gives `given_up` as soon as `stop` is set (null: never): the cycle is then
  /// of no use any more.
  Resumed resume(const Remembered& from, double gap_s, const std::atomic<bool>* stop = nullptr);

  /// Before the first step, where resume() cannot be: the start is a cold one, but the estimator begins with what was
  /// known of the machine (heats, contacts, films and their laws, lags; not offsets, inlets or start), widened by
  /// `plan.drift`. By names, so from another network of the same spindle too, whose nominal values may differ. Gives
  /// how many parameters were taken: 0, and nothing changed, where it is of another spindle, began with another
  /// calibration, or has no names. Allocates.
  int begin_with_machine(const Remembered& from);

 private:
  bool ready_to_start();
  void start_from(double temperature_K);
  void start();
  std::optional<Eigen::VectorXd> stand_still(double gap_s, const std::atomic<bool>* stop);
  /// Through gap_s of model time without a reading. Gives the time since sensors were looked at last. Once started.
  double catch_up(double gap_s);
  void take_orders(const PlcCommand& command);
  OrderResult take_length(const PlcCommand& command);
  /// Of the length that was handed to the estimator: what its update made of it.
  OrderResult length_result();
  OrderResult take_tare(const PlcCommand& command);
  void take_counts(const Cycle& running);
  /// Towards its end after take_over(), by no more than most_m; the published nose has moved by nose_moved_m.
  void move_tare(double most_m, double nose_moved_m);
  void publish_prediction();
  void note(Integrated integrated);
  /// A prediction beyond all plausibility (plausible.hpp) is given up for that of the uncorrected model, and the
  /// estimate begins anew from there.
  void guard_prediction();
  /// Factor on deformations that the estimate says; 1 where nothing is corrected.
  double expansion() const;
  void label(std::int64_t missed);

  const rom::Network& network_;
  std::shared_ptr<const rom::NetworkOperator> shared_operator_;
  CyclePlan plan_;
  Model model_;
  Model uncorrected_;
  HeatPaths heat_paths_;
  Corrector corrector_;
  SensorWatch watch_;
  SensedInputs sensed_;
  Judgement judgement_;
  rom::OperatingState operating_;
  Eigen::VectorXd start_K_;
  Snapshot snapshot_;
  Compensation compensation_;
  std::optional<Forecast> forecast_;
  std::int64_t first_ns_ = 0;
  std::uint32_t tare_orders_ = 0;
  std::uint32_t displacements_ = 0;
  long length_due_ = 0;                 ///< the estimator's update that takes in the last length; 0: none is on its way
  std::uint32_t acknowledgements_ = 0;  ///< of the command
  std::uint32_t acknowledgements_kept_ = 0;  ///< of runs before and of this one
  SwitchOrder correction_order_ = SwitchOrder::as_configured;
  OrderResults results_{};
  std::uint16_t outside_faults_ = 0;
  bool has_stepped_ = false;
  bool started_ = false;
  double waited_s_ = 0.0;
  double tare_to_come_m_ = 0.0;  ///< what the tare still moves by after take_over()
  std::string network_sha256_;
  double implausible_until_s_ = 0.0;  ///< model time
};

inline constexpr std::size_t history_room = 256;
class NetworkExchange;

using SnapshotRing = Ring<Snapshot, history_room>;

/// Where the cycle thread takes its inputs from and leaves its results; no end of them can make it wait.
struct CyclePorts {
  DeviceInbox& devices;
  Latest<PlcSignals>& plc;
  Latest<Snapshot>& server;
  SnapshotRing* history = nullptr;              ///< null: no history is kept
  std::atomic<std::uint64_t>* lost = nullptr;   ///< snapshots that the history had no room for
  OnRequest<Remembered>* remembered = nullptr;  ///< null: nobody asks. Sized already by Cycle::remember()
  OrderDesk* orders = nullptr;                  ///< null: nobody gives orders
  Latest<Snapshot>* events = nullptr;           ///< null: nobody says what happens
  Troubles* troubles = nullptr;                 ///< null: the others have none
  Pulse* pulse = nullptr;                       ///< null: nobody watches
  std::array<Latest<Snapshot>*, 2> shown{};     ///< HTTP port, plant network; null: that one is not there
  NetworkExchange* exchange = nullptr;          ///< null: the network stays what it is. Of the cycle that is run
};

/// Runs the cycle at absolute deadlines until `stop` is set.
void run_cycle(Cycle& cycle, const CyclePlan& plan, Clock& clock, const CyclePorts& ports,
               const std::atomic<bool>& stop);

}  // namespace spindle_twin::firmware

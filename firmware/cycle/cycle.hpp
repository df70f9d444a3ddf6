#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "firmware/cycle/correct.hpp"
#include "firmware/cycle/device_inbox.hpp"
#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/order_desk.hpp"
#include "firmware/cycle/publish.hpp"
#include "firmware/cycle/remember.hpp"
#include "firmware/cycle/troubles.hpp"
#include "firmware/cycle/watch_sensors.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/pulse.hpp"

namespace spindle_twin::firmware {

/// What was of use in what a cycle was to remember.
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

  /// Before the first step: goes on from what was remembered gap_s of model time ago. The spindle is taken to have
  /// stood still since, with environments and flows as they were then; sensitivities and variances are carried through
  /// it, and the estimator is told what the spindle would have warmed if it had run all the time: first readings that
  /// say so find it open to that. The estimator goes on only where its parameters and sensors are the same. Nothing is
  /// changed where nothing fits. Allocates. Gives `given_up` as soon as `stop` is set (null: never): the cycle is then
  /// of no use any more.
  Resumed resume(const Remembered& from, double gap_s, const std::atomic<bool>* stop = nullptr);

 private:
  bool ready_to_start();
  void start_from(double temperature_K);
  void start();
  std::optional<Eigen::VectorXd> stand_still(double gap_s, const std::atomic<bool>* stop);
  /// Through gap_s of model time without a reading. Gives the time since sensors were looked at last. Once started.
  double catch_up(double gap_s);
  void take_orders(const PlcCommand& command);
  OrderResult take_length(const PlcCommand& command);
  OrderResult take_tare(const PlcCommand& command);
  void note(Integrated integrated);
  /// A prediction beyond all plausibility (plausible.hpp) is given up for that of the uncorrected model, and the
  /// estimate begins anew from there.
  void guard_prediction();
  void label(std::int64_t missed);

  const rom::Network& network_;
  std::shared_ptr<const rom::NetworkOperator> shared_operator_;
  CyclePlan plan_;
  Model model_;
  Model uncorrected_;
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
  std::uint32_t acknowledgements_ = 0;       ///< of the command
  std::uint32_t acknowledgements_kept_ = 0;  ///< of runs before and of this one
  SwitchOrder correction_order_ = SwitchOrder::as_configured;
  OrderResults results_{};
  std::uint16_t outside_faults_ = 0;
  bool has_stepped_ = false;
  bool started_ = false;
  double waited_s_ = 0.0;
  double implausible_until_s_ = 0.0;  ///< model time
};

inline constexpr std::size_t history_room = 256;
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
  Latest<Snapshot>* shown = nullptr;            ///< null: no HTTP port shows them
};

/// Runs the cycle at absolute deadlines until `stop` is set.
void run_cycle(Cycle& cycle, const CyclePlan& plan, Clock& clock, const CyclePorts& ports,
               const std::atomic<bool>& stop);

}  // namespace spindle_twin::firmware

#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

/// One order of the PLC as it was written.
struct Order {
  OrderKind kind = OrderKind::none;
  std::uint16_t id = 0;          ///< the PLC's own number for it
  std::uint16_t code = 0;        ///< what was written; of a switch 0 off, 1 on, not_present as configured
  Displacement length;           ///< of the kind `length`
  double trial_m = not_a_value;  ///< of the kind `trial` with trial_begins: the value to try
};
// Codes of the kind `trial`.
inline constexpr std::uint16_t trial_begins = 1, trial_ends = 2, trial_goes_on = 3;
inline constexpr std::uint16_t not_present_code = 65535;

/// What one cycle made of the orders of each kind, by OrderKind; none where it was given none.
using OrderResults = std::array<OrderResult, order_kind_codes.size()>;

// What a tare may have taken, however warm spindle and sensors were: beyond, a file is damaged.
inline constexpr double most_tare_m = 0.01;
inline constexpr double most_sensor_tare_K = 50.0;

/// What holds until another order changes it, and must outlive a restart: as it stands in the orders' file.
struct StandingOrders {
  std::uint32_t revision = 0;  ///< counts up with each order obeyed
  SwitchOrder correction = SwitchOrder::as_configured;
  SwitchOrder compensation = SwitchOrder::as_configured;
  double tare_m = 0.0;
  std::uint32_t sensor_tares = 0;
  std::array<double, slots::key_points> sensor_tare_K{};
  std::array<double, slots::key_points> sensor_tare_deviation_K{};
  std::uint32_t acknowledgements = 0;
  bool lost = false;                      ///< some of it was lost and nobody has acknowledged that
  std::array<char, 64> network_sha256{};  ///< whose nose and key points they are of, hex; zeros: nobody said
};

/// Where orders pass from the server to the cycle, and what holds of them from the cycle to the thread that writes it
/// to the disk. Each order gets a result: done only once it is on the disk, if it must outlive a restart. No side
/// waits for another; an order that finds the queue full is not taken.
class OrderDesk {
 public:
  static constexpr std::size_t room = 64;

  // The server's thread.
  bool has_room_for(std::size_t orders) const { return queue_.size() + orders <= room; }
  void give(const Order& order) { queue_.push(order); }

  // The cycle's thread; no allocation.
  /// What holds before the first order.
  PlcCommand first_command() const {
    PlcCommand command;
    command.correction = correction_;
    command.compensation = compensation_;
    return command;
  }
  /// Adds the next orders to `command`: in the order in which they came, as long as each is of a later kind than the
  /// one before, so that a row of the history tells all of them. None while one of its kind waits for the prediction or
  /// an update; lengths and tares wait for each other too, as what they mean hangs on the zero. A switch, an
  /// acknowledgement or a trial overtakes what waits. That a trial goes on is no order of its own: it gets
  /// no record.
  void hand_out(PlcCommand& command);
  /// After the cycle: the results of what was handed out, and of those that wait for the disk.
  void settle(const OrderResults& results, const StandingOrders& standing, Snapshot& snapshot);

  /// What holds is now said of another network: to be written once more.
  void renew(const StandingOrders& standing);

  // The thread that writes standing orders.
  Latest<StandingOrders>& standing() { return standing_; }
  /// The first `revision` orders are on the disk, or could not be written.
  void note_kept(std::uint32_t revision) { kept_.store(revision, std::memory_order_release); }
  void note_not_kept(std::uint32_t revision) { not_kept_.store(revision, std::memory_order_release); }

  /// Before the first cycle: what holds from a run before.
  void begin_with(const StandingOrders& standing);

 private:
  struct Record {
    OrderRecord told;
    std::uint32_t revision = 0;  ///< done when so many are on the disk
    bool handed_out = false;     ///< the cycle has it and says what becomes of it
  };
  void add(const Order& order, PlcCommand& command);
  OrderResult kept_result(std::uint32_t revision) const;

  Ring<Order, room> queue_;
  std::array<Order, room> held_{};  ///< out of the queue, the oldest first
  std::size_t held_count_ = 0;
  std::array<Record, order_records> records_{};  ///< newest first
  std::uint32_t orders_ = 0;
  std::uint32_t revision_ = 0;
  SwitchOrder correction_ = SwitchOrder::as_configured;
  SwitchOrder compensation_ = SwitchOrder::as_configured;
  std::array<bool, order_kind_codes.size()> waits_{};  ///< an order of this kind waits for the cycle
  Latest<StandingOrders> standing_;
  std::atomic<std::uint32_t> kept_{0};
  std::atomic<std::uint32_t> not_kept_{0};
};

}  // namespace spindle_twin::firmware

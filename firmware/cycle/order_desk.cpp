#include "firmware/cycle/order_desk.hpp"

#include <algorithm>

namespace spindle_twin::firmware {
namespace {

bool is_known(const Order& order) {
  switch (order.kind) {
    case OrderKind::tare:
      return order.code == 1 || order.code == 2;
    case OrderKind::sensors:
    case OrderKind::trial:
      return order.code >= 1 && order.code <= 3;
    case OrderKind::length:
    case OrderKind::acknowledge:
      return order.code == 1;
    case OrderKind::correction:
    case OrderKind::compensation:
      return order.code <= 1 || order.code == not_present_code;
    case OrderKind::none:
      break;
  }
  return true;
}

/// Lengths and tares: what one means depends on those before it.
bool hangs_on_the_zero(OrderKind kind) {
  return kind == OrderKind::length || kind == OrderKind::sensors || kind == OrderKind::tare;
}

SwitchOrder switch_of(std::uint16_t code) {
  if (code == not_present_code) return SwitchOrder::as_configured;
  return code == 0 ? SwitchOrder::off : SwitchOrder::on;
}

void add_to(PlcCommand& command, const Order& order) {
  switch (order.kind) {
    case OrderKind::correction:
      command.correction = switch_of(order.code);
      break;
    case OrderKind::compensation:
      command.compensation = switch_of(order.code);
      break;
    case OrderKind::length:
      command.displacement = order.length;
      ++command.displacements;
      break;
    case OrderKind::sensors:
      command.sensor_order = order.code == 1   ? SensorOrder::tare
                             : order.code == 2 ? SensorOrder::clear_tare
                                               : SensorOrder::acknowledge;
      ++command.sensor_orders;
      break;
    case OrderKind::tare:
      command.tare_order = order.code == 1 ? TareOrder::take : TareOrder::clear;
      ++command.tare_orders;
      break;
    case OrderKind::acknowledge:
      ++command.acknowledgements;
      break;
    case OrderKind::trial:
      command.trial.value_m = order.code == trial_begins ? order.trial_m : not_a_value;
      ++command.trial.orders;
      break;
    case OrderKind::none:
      break;
  }
}

}  // namespace

void OrderDesk::begin_with(const StandingOrders& standing) {
  revision_ = standing.revision;
  correction_ = standing.correction;
  compensation_ = standing.compensation;
  kept_.store(standing.revision, std::memory_order_release);
}

void OrderDesk::add(const Order& order, PlcCommand& command) {
  if (order.kind == OrderKind::trial && order.code == trial_goes_on) {
    ++command.trial.renewals;
    return;
  }
  std::move_backward(records_.begin(), records_.end() - 1, records_.end());
  const bool known = is_known(order);
  records_[0] = {{++orders_, order.id, order.kind, known ? OrderResult::waiting : OrderResult::unknown}, 0, known};
  if (known) add_to(command, order);
}

void OrderDesk::hand_out(PlcCommand& command) {
  while (held_count_ < held_.size() && queue_.pop(held_[held_count_])) ++held_count_;
  OrderKind last = OrderKind::none;
  std::array<bool, order_kind_codes.size()> blocked = waits_;
  bool zero_waits = false;
  std::size_t left = 0;
  for (std::size_t i = 0; i < held_count_; ++i) {
    const Order order = held_[i];
    bool& blocks = blocked[static_cast<std::size_t>(order.kind)];
    if (order.kind <= last || blocks || (zero_waits && hangs_on_the_zero(order.kind))) {
      blocks = true;
      zero_waits = zero_waits || hangs_on_the_zero(order.kind);
      held_[left++] = order;
      continue;
    }
    last = order.kind;
    add(order, command);
  }
  held_count_ = left;
}

OrderResult OrderDesk::kept_result(std::uint32_t revision) const {
  if (kept_.load(std::memory_order_acquire) >= revision) return OrderResult::done;
  return not_kept_.load(std::memory_order_acquire) >= revision ? OrderResult::not_kept : OrderResult::waiting;
}

void OrderDesk::renew(const StandingOrders& standing) {
  StandingOrders now = standing;
  now.revision = revision_;
  standing_.write(now);
}

void OrderDesk::settle(const OrderResults& results, const StandingOrders& standing, Snapshot& snapshot) {
  const std::uint32_t before = revision_;
  waits_.fill(false);
  // The oldest first: revisions count in the order of the orders.
  for (std::size_t i = records_.size(); i-- > 0;) {
    Record& record = records_[i];
    if (!record.handed_out) continue;
    record.told.result = results[static_cast<std::size_t>(record.told.kind)];
    if (record.told.result == OrderResult::waiting) {
      waits_[static_cast<std::size_t>(record.told.kind)] = true;
      continue;
    }
    record.handed_out = false;
    // A measured length lives in the estimate, which the checkpoint keeps; a trial outlives no restart.
    const bool is_kept = record.told.kind != OrderKind::length && record.told.kind != OrderKind::trial;
    if (record.told.result == OrderResult::done && is_kept) record.revision = ++revision_;
  }
  if (revision_ != before) {
    StandingOrders now = standing;
    now.revision = revision_;
    standing_.write(now);
  }
  snapshot.orders = orders_;
  for (std::size_t i = 0; i < records_.size(); ++i) {
    if (records_[i].revision > 0) records_[i].told.result = kept_result(records_[i].revision);
    snapshot.last_orders[i] = records_[i].told;
  }
}

}  // namespace spindle_twin::firmware

#include "firmware/serve/spindle_registers.hpp"

#include <algorithm>
#include <new>
#include <vector>

#include "firmware/serve/fill_image.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr int talks_cyclically = 3;  ///< a client that goes on after it told a signal

std::uint16_t code_of(SwitchOrder order) {
  if (order == SwitchOrder::as_configured) return not_present_code;
  return order == SwitchOrder::on ? 1 : 0;
}

/// Input registers end with the last block that is not the command block; that one lies between them, and the gate
/// keeps it out.
constexpr int input_registers() {
  int end = 0;
  for (const RegisterBlock& block : register_blocks) {
    if (!block.command) end = std::max(end, block.address + block.length);
  }
  return end;
}

}  // namespace

SpindleRegisters::SpindleRegisters(const SpindlePorts& ports, Clock& clock)
    : ports_(ports),
      clock_(clock),
      mapping_(modbus_mapping_new(0, 0, static_cast<int>(image_size()), input_registers())) {
  if (mapping_ == nullptr) throw std::bad_alloc();
  clear_commands(image_);
  const PlcCommand first = ports_.orders.first_command();
  switched_ = {code_of(first.correction), code_of(first.compensation)};
  image_[entry_of(Register::command_correction).address] = switched_.correction;
  image_[entry_of(Register::command_compensation).address] = switched_.compensation;
  const WriteRange writable = writable_registers();
  std::copy_n(image_.begin() + writable.address, writable.count, mapping_->tab_registers + writable.address);
  fill_image(snapshot_, clock_.now_ns(), image_);
}

bool SpindleRegisters::has_room_for(WriteRange written) const {
  return !may_order(written) || ports_.orders.has_room_for(most_orders);
}

modbus_mapping_t* SpindleRegisters::renew() {
  ports_.snapshots.read(snapshot_);
  fill_image(snapshot_, clock_.now_ns(), image_);
  std::copy(image_.begin(), image_.end(), mapping_->tab_registers);
  std::copy_n(image_.begin(), input_registers(), mapping_->tab_input_registers);
  return mapping_.get();
}

SignalSet SpindleRegisters::take(WriteRange written) {
  const WriteRange writable = writable_registers();
  std::copy_n(mapping_->tab_registers + writable.address, writable.count, image_.begin() + writable.address);
  for (const Order& order : take_orders(written, switched_, image_)) give(order);
  return take_signals(written, clock_.now_ns(), image_, told_);
}

bool SpindleRegisters::take(const Order& order) {
  if (!ports_.orders.has_room_for(1)) return false;
  if (order.kind == OrderKind::correction) put_code(Register::command_correction, order.code);
  if (order.kind == OrderKind::compensation) put_code(Register::command_compensation, order.code);
  give(order);
  return true;
}

void SpindleRegisters::put_code(Register which, std::uint16_t code) {
  const int address = entry_of(which).address;
  image_[static_cast<std::size_t>(address)] = mapping_->tab_registers[address] = code;
}

void SpindleRegisters::give(const Order& order) {
  if (order.kind == OrderKind::correction) switched_.correction = order.code;
  if (order.kind == OrderKind::compensation) switched_.compensation = order.code;
  ports_.orders.give(order);
}

void SpindleRegisters::note_request(Talk& talk, SignalSet told) {
  if (talk.number == 0 && told.none()) return;
  if (talk.number == 0) talk.number = ++talks_;
  const std::int64_t now_ns = clock_.now_ns();
  talk.requests = std::min(talk.requests + 1, talks_cyclically);
  bool is_new = told.any();
  for (std::size_t s = 0; s < signal_count; ++s) {
    if (told.test(s)) told_by_[s] = talk.number;
    const bool is_watched = told_.alive_ns[s] != 0;
    const bool is_alive = talk.requests >= talks_cyclically || (is_watched && told.test(s));
    if (told_by_[s] != talk.number || !is_alive) continue;
    told_.alive_ns[s] = now_ns;
    is_new = true;
  }
  if (is_new) ports_.signals.write(told_);
}

}  // namespace spindle_twin::firmware

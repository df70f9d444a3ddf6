#pragma once

#include <modbus.h>

#include <cstdint>
#include <memory>

#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/order_desk.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/serve/command_registers.hpp"
#include "firmware/serve/frame_gate.hpp"
#include "firmware/serve/register_map.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

/// What the server needs of one spindle: under which units it is asked, and what passes to and from its cycle, which
/// must outlive the server.
struct SpindlePorts {
  Units units;
  Latest<Snapshot>& snapshots;
  Latest<PlcSignals>& signals;
  OrderDesk& orders;
};

/// What one connection has said to one spindle.
struct Talk {
  int requests = 0;          ///< since it first told a signal; saturates
  std::uint64_t number = 0;  ///< among those that have told a signal; 0: it has told none
};

/// The registers of one spindle: read from the newest snapshot, written by clients. For the server's thread.
class SpindleRegisters {
 public:
  SpindleRegisters(const SpindlePorts& ports, Clock& clock);

  const Units& units() const { return ports_.units; }
  /// Whether all orders that this request may bring would be taken.
  bool has_room_for(WriteRange written) const;
  /// The newest snapshot, for libmodbus to read from and to write to. Of this object.
  modbus_mapping_t* renew();
  /// Takes over what a request wrote to the mapping: signals are the newest, orders are queued one by one. Gives the
  /// signals that it told.
  SignalSet take(WriteRange written);
  /// Queues an order that did not come by registers, which keep what a PLC has written but for the switches; false: no
  /// room.
  bool take(const Order& order);
  /// A request has come by the connection of this talk; it told these signals of this spindle. Who told signals and
  /// goes on talking is watched: when it falls silent, the signals that it was the last to tell are no longer believed,
  /// whoever else talks. Who wrote once and never came back is a tool, or writes on change only.
  void note_request(Talk& talk, SignalSet told);

 private:
  struct FreeMapping {
    void operator()(modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }
  };
  void give(const Order& order);
  void put_code(Register which, std::uint16_t code);

  SpindlePorts ports_;
  Clock& clock_;
  std::unique_ptr<modbus_mapping_t, FreeMapping> mapping_;
  Snapshot snapshot_;
  PlcSignals told_;
  std::array<std::uint64_t, signal_count> told_by_{};  ///< Talk::number of who told each last
  std::uint64_t talks_ = 0;
  RegisterImage image_{};
  Switched switched_;  ///< by the last orders
};

}  // namespace spindle_twin::firmware

#pragma once

#include <modbus.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/serve/frame_gate.hpp"
#include "firmware/serve/register_map.hpp"
#include "firmware/serve/serve_plan.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

/// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor();
  int get() const { return fd_; }

 private:
  int fd_;
};

/// Serves the register map by Modbus/TCP to any number of clients in the one thread that calls run().
/// Every socket is non-blocking, every request passes judge_frame() before libmodbus sees it, and only whole requests
/// are handed over; a request that is not whole within the deadline ends its connection. So no client can hold up
/// another one. One request is answered from one snapshot.
class ModbusServer {
 public:
  /// Listens. Throws rom::InputError naming address and port if that is not possible.
  ModbusServer(const ServePlan& plan, Clock& clock, Latest<Snapshot>& snapshots, Latest<PlcCommand>& commands);
  ~ModbusServer();
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;

  int port() const;
  void run();
  /// Ends run(); from any thread or signal handler.
  void stop();

 private:
  struct Connection {
    Descriptor socket;
    std::int64_t deadline_ns = 0;  ///< of the frame that has begun; 0: none has
    std::size_t awaited = 1;       ///< bytes below which poll() stays quiet
    bool open = true;
  };

  void accept_all();
  void look_at(Connection& connection, short events);
  void await(Connection& connection, std::size_t bytes);
  void answer(Connection& connection, const Gate& gate, std::span<const std::uint8_t> frame);
  bool hand_over(Connection& connection, const Gate& gate);
  void refresh();
  int poll_timeout_ms() const;

  ServePlan plan_;
  Clock& clock_;
  Latest<Snapshot>& snapshots_;
  Latest<PlcCommand>& commands_;
  Descriptor listener_;
  Descriptor wake_;
  std::vector<Connection> connections_;
  modbus_t* modbus_ = nullptr;
  modbus_mapping_t* mapping_ = nullptr;
  Snapshot snapshot_;
  PlcCommand command_;
  RegisterImage image_{};
};

}  // namespace spindle_twin::firmware

#pragma once

#include <modbus.h>

#include <array>
#include <cstdint>
#include <future>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "firmware/serve/acceptor.hpp"
#include "firmware/serve/descriptor.hpp"
#include "firmware/serve/frame_gate.hpp"
#include "firmware/serve/serve_plan.hpp"
#include "firmware/serve/spindle_registers.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {

/// Serves the register map of each spindle, by its units, by Modbus/TCP to any number of clients in the one thread that
/// calls run().
/// Every socket is non-blocking, every request passes judge_frame() before libmodbus sees it, and only whole requests
/// are handed over; a request that is not whole within the deadline ends its connection. So no client can hold up
/// another one. A connection that is idle for too long is closed, and the longest idle one makes room for a new client.
/// One request is answered from one snapshot. Signals go to the cycle as the newest, orders one by one.
class ModbusServer {
 public:
  /// Listens. No two spindles may have a unit in common. Throws rom::InputError naming address and port if listening is
  /// not possible.
  ModbusServer(const ServePlan& plan, Clock& clock, const std::vector<SpindlePorts>& spindles);
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;

  /// Of the plain port; 0: there is none.
  int port() const;
  /// Serves one more client, whose bytes come from elsewhere by this connection: TCP inside this computer,
  /// non-blocking. `host`: its IPv4 address, host byte order. It is closed where there is no room for it. Any thread.
  void adopt(Descriptor socket, std::uint32_t host, bool may_write);
  /// Hands an order to the spindle of this number as if a client had written it, for who waits in another thread, 2 s
  /// at the most; false: the queue of orders is full, or this does not run.
  bool order(std::size_t spindle, const Order& order);
  /// Until stop(); a failing poll() is tried again.
  void run();
  /// Ends run(); from any thread or signal handler.
  void stop();

 private:
  struct Connection {
    Descriptor socket;
    std::int64_t deadline_ns = 0;  ///< of the frame that has begun; 0: none has
    std::size_t awaited = 1;       ///< bytes below which poll() stays quiet
    bool open = true;
    std::uint32_t host = 0;     ///< IPv4 address, host byte order
    bool may_write = false;     ///< the command block; else a write is exception 2, as to any other register
    std::int64_t asked_ns = 0;  ///< last request, or the connection itself
    std::vector<Talk> talks;    ///< by spindle
  };

  struct Newcomer {
    Descriptor socket;
    std::uint32_t host = 0;
    bool may_write = false;
  };

  /// An order from another thread.
  struct Asked {
    std::uint64_t number = 0;
    std::size_t spindle = 0;
    Order order;
    std::promise<bool> taken;
  };

  void accept_all();
  void adopt_all();
  void admit(Newcomer newcomer);
  bool make_room_for(std::uint32_t host);
  void note_request(Connection& connection, const SpindleRegisters* to = nullptr, SignalSet told = {});
  void look_at(Connection& connection, short events);
  void await(Connection& connection, std::size_t bytes);
  void answer(Connection& connection, const Gate& gate, std::span<const std::uint8_t> frame);
  bool hand_over(Connection& connection, const Gate& gate, std::uint8_t unit);
  SpindleRegisters& spindle_of(std::uint8_t unit);
  std::int64_t idle_ns() const { return static_cast<std::int64_t>(1e9 * plan_.idle_s); }
  int poll_timeout_ms() const;

  ServePlan plan_;
  Clock& clock_;
  std::vector<SpindleRegisters> spindles_;
  Units units_;  ///< of all spindles
  Acceptor acceptor_;
  Descriptor wake_, adopting_;
  std::mutex guard_;
  std::vector<Newcomer> adopted_;  ///< behind guard_, as the two that follow
  std::vector<Asked> asked_;
  std::uint64_t asked_last_ = 0;
  std::vector<Connection> connections_;
  std::unique_ptr<modbus_t, void (*)(modbus_t*)> modbus_;
  LogLimit refusals_;
};

}  // namespace spindle_twin::firmware

#pragma once

#include <modbus.h>
#include <sys/types.h>

namespace spindle_twin::bench {

/// libmodbus as its manual shows it: accept, receive, reply; one client, registers that stand still.
class BareModbusServer {
 public:
  /// Listens on a free port of the loopback. Throws std::runtime_error where that fails.
  BareModbusServer();
  ~BareModbusServer();
  BareModbusServer(const BareModbusServer&) = delete;
  BareModbusServer& operator=(const BareModbusServer&) = delete;

  int port() const { return port_; }
  /// Serves one client in a process of its own, which ends with that client; its id.
  pid_t start();

 private:
  void serve();

  int port_;
  modbus_t* modbus_;
  modbus_mapping_t* mapping_;
  int listener_;
};

/// A port of the loopback that was free a moment ago.
int free_port();

}  // namespace spindle_twin::bench

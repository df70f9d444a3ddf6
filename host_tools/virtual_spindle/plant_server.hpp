#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "host_tools/virtual_spindle/plant_registers.hpp"

struct _modbus;

namespace spindle_twin::host_tools {

/// A Modbus/TCP server for one block of registers, one thread, whole frames only: a client that dribbles bytes waits
/// in its own buffer and holds up nobody. Writes are refused by libmodbus (function codes 3 and 4 are answered).
class PlantServer {
 public:
  /// Listens on address:port; throws rom::InputError if that is not possible.
  PlantServer(const std::string& address, int port);
  ~PlantServer();
  PlantServer(const PlantServer&) = delete;
  PlantServer& operator=(const PlantServer&) = delete;

  /// From any thread.
  void publish(const PlantRegisters& registers);

  /// True once a request was answered. From any thread.
  bool was_read() const { return was_read_; }

  /// Serves until `stop` is set; looks at it at least ten times a second.
  void serve(const std::atomic<bool>& stop);

 private:
  struct Client;
  void answer(Client& client);

  std::unique_ptr<_modbus, void (*)(_modbus*)> context_;
  int listener_ = -1;
  std::mutex mutex_;
  PlantRegisters registers_{};
  std::atomic<bool> was_read_{false};
};

}  // namespace spindle_twin::host_tools

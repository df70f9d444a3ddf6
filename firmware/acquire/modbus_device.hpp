#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "firmware/acquire/driver.hpp"
#include "firmware/acquire/modbus_answer.hpp"
#include "firmware/acquire/modbus_presets.hpp"
#include "firmware/acquire/read_plan.hpp"

namespace spindle_twin::firmware {

/// A data-acquisition device that answers Modbus/TCP.
struct ModbusPlan final : DriverPlan {
  std::string address = "127.0.0.1";  ///< IPv4
  int port = 502;
  int unit = 1;
  double timeout_s = 0.5;                ///< clock time, for an answer
  const ModbusPreset* preset = nullptr;  ///< null: each channel names its register
  std::vector<RegisterSource> sources;   ///< by channel

  ChannelSource add_channel(const rom::TomlTable& table) override;
  std::unique_ptr<Driver> make_driver(Clock& clock) const override;
  std::string where() const override { return address + ":" + std::to_string(port); }
};

/// Keys address, port, unit, timeout_s, preset. Throws rom::InputError.
std::shared_ptr<DriverPlan> read_modbus_plan(const rom::TomlTable& device);

/// Polls a device as Modbus/TCP client (libmodbus).
/// An answer counts only if transaction, protocol id, unit, function and lengths are those of the question; another one
/// ends the connection. An answer that the device refuses (exception) keeps the connection: only its channels grow old.
class ModbusDevice final : public Driver {
 public:
  ModbusDevice(const ModbusPlan& plan, Clock& clock);
  ~ModbusDevice() override;
  ModbusDevice(const ModbusDevice&) = delete;
  ModbusDevice& operator=(const ModbusDevice&) = delete;

  /// Connects where it must, asks for all channels. Comes back within timeout_s for connecting and for each question.
  Step step(DeviceReadings& readings) override;

 private:
  bool connect();
  bool ask(const ReadQuestion& question, std::span<std::uint8_t> frame, CheckedAnswer& answer);
  bool poll(DeviceReadings& readings);
  void note_refused(std::size_t request, std::uint8_t exception);

  struct Context;
  ModbusPlan plan_;
  Clock& clock_;
  std::vector<ReadRequest> requests_;
  std::vector<std::uint8_t> refused_;  ///< exception that each request got last; 0: none
  std::uint16_t transaction_ = 0;
  std::int64_t answered_ns_ = 0;  ///< when the last answer came
  std::string reason_;            ///< why the device does not answer
  LogLimit changes_{6, 60.0};
  std::unique_ptr<Context> context_;
};

}  // namespace spindle_twin::firmware

#include "firmware/acquire/modbus_device.hpp"

#include <modbus.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <new>

namespace spindle_twin::firmware {

struct ModbusDevice::Context {
  explicit Context(const DevicePlan& plan) : modbus(modbus_new_tcp(plan.address.c_str(), plan.port)) {
    if (modbus == nullptr) throw std::bad_alloc();
    modbus_set_slave(modbus, plan.unit);
    const auto seconds = static_cast<std::uint32_t>(plan.timeout_s);
    const auto micros = static_cast<std::uint32_t>(std::round((plan.timeout_s - seconds) * 1e6));
    modbus_set_response_timeout(modbus, seconds, micros);
  }
  ~Context() {
    modbus_close(modbus);
    modbus_free(modbus);
  }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  modbus_t* modbus;
};

double back_off_s(int failures) { return std::min(5.0, 0.1 * std::ldexp(1.0, std::min(failures, 10))); }

ModbusDevice::ModbusDevice(DevicePlan plan, Clock& clock, Latest<DeviceFrame>& frames)
    : plan_(std::move(plan)), clock_(clock), frames_(frames), requests_(plan_requests(plan_.channels)) {}

ModbusDevice::~ModbusDevice() = default;

void ModbusDevice::sleep_until(std::int64_t time_ns, const std::atomic<bool>& stop) {
  while (!stop.load(std::memory_order_relaxed) && clock_.now_ns() < time_ns) {
    constexpr std::int64_t slice_ns = 100'000'000;
    clock_.sleep_until_ns(std::min(time_ns, clock_.now_ns() + slice_ns));
  }
}

bool ModbusDevice::connect() {
  context_ = std::make_unique<Context>(plan_);
  return modbus_connect(context_->modbus) == 0;
}

Reading& ModbusDevice::reading_of(const Channel& channel) {
  switch (channel.kind) {
    case Channel::Kind::sensor:
      return frame_.sensors[channel.index];
    case Channel::Kind::displacement:
      return frame_.displacements[channel.index];
    default:
      return frame_.signals[channel.index];
  }
}

bool ModbusDevice::poll() {
  std::array<std::uint16_t, MODBUS_MAX_READ_REGISTERS> words{};
  for (const ReadRequest& request : requests_) {
    const auto read = request.table == RegisterTable::input ? modbus_read_input_registers : modbus_read_registers;
    if (read(context_->modbus, request.address, request.count, words.data()) != request.count) {
      const bool refused = errno > MODBUS_ENOBASE && errno <= EMBXGTAR;
      if (!refused) return false;
      spdlog::debug("device refuses {} registers from {}: {}", request.count, request.address, modbus_strerror(errno));
      continue;
    }
    const std::int64_t now_ns = clock_.now_ns();
    for (const std::size_t c : request.channels) {
      const Channel& channel = plan_.channels[c];
      const std::size_t at = static_cast<std::size_t>(channel.source.address - request.address);
      const Reading reading{decode(channel.source, std::span(words).subspan(at)), now_ns};
      reading_of(channel) = reading;
    }
  }
  return true;
}

void ModbusDevice::run(const std::atomic<bool>& stop) {
  const auto period_ns = static_cast<std::int64_t>(1e9 * plan_.poll_s);
  int failures = 0;
  while (!stop.load(std::memory_order_relaxed)) {
    if (connect()) {
      std::int64_t due_ns = clock_.now_ns();
      while (!stop.load(std::memory_order_relaxed) && poll()) {
        if (!frame_.connected) spdlog::info("device {}:{} answers", plan_.address, plan_.port);
        failures = 0;
        frame_.connected = true;
        frames_.write(frame_);
        due_ns = std::max(due_ns + period_ns, clock_.now_ns());
        sleep_until(due_ns, stop);
      }
    }
    if (stop.load(std::memory_order_relaxed)) return;
    if (failures == 0) {
      spdlog::warn("device {}:{} does not answer ({}); trying on", plan_.address, plan_.port, modbus_strerror(errno));
    }
    frame_.connected = false;
    frames_.write(frame_);
    context_.reset();
    sleep_until(clock_.now_ns() + static_cast<std::int64_t>(1e9 * back_off_s(failures++)), stop);
  }
}

}  // namespace spindle_twin::firmware

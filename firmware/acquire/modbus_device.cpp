#include "firmware/acquire/modbus_device.hpp"

#include <modbus.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
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
    : plan_(std::move(plan)),
      clock_(clock),
      frames_(frames),
      requests_(plan_requests(plan_.channels)),
      refused_(requests_.size(), 0) {}

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

/// False where the connection is of no more use; reason_ says why.
bool ModbusDevice::ask(const ReadQuestion& question, std::span<std::uint8_t> frame, CheckedAnswer& answer) {
  const int socket = modbus_get_socket(context_->modbus);
  const auto sent = encode(question);
  if (send(socket, sent.data(), sent.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(sent.size())) {
    reason_ = std::strerror(errno);
    return false;
  }
  const std::int64_t deadline_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * plan_.timeout_s);
  std::size_t received = 0;
  while (true) {
    const std::int64_t left_ms = (deadline_ns - clock_.now_ns()) / 1'000'000;
    pollfd readable{socket, POLLIN, 0};
    if (left_ms < 0 || ::poll(&readable, 1, static_cast<int>(left_ms) + 1) == 0) {
      reason_ = "no answer in time";
      return false;
    }
    const ssize_t got = recv(socket, frame.data() + received, frame.size() - received, MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (got <= 0) {
      reason_ = got == 0 ? "it closed the connection" : std::strerror(errno);
      return false;
    }
    received += static_cast<std::size_t>(got);
    answer = check_answer(question, frame.first(received));
    if (answer.is == Answer::wrong) reason_ = "its answer is of another request, unit, protocol or length";
    if (answer.is != Answer::not_whole) return answer.is != Answer::wrong;
  }
}

void ModbusDevice::note_refused(std::size_t request, std::uint8_t exception) {
  if (refused_[request] == exception) return;
  refused_[request] = exception;
  const ReadRequest& of = requests_[request];
  const auto before = changes_.pass(clock_.now_ns());
  if (!before) return;
  if (exception != 0) {
    spdlog::warn("device {}:{} refuses registers {} to {} with exception {}{}", plan_.address, plan_.port, of.address,
                 of.address + of.count - 1, exception, LogLimit::also(*before));
  } else {
    spdlog::info("device {}:{} gives registers {} to {} again{}", plan_.address, plan_.port, of.address,
                 of.address + of.count - 1, LogLimit::also(*before));
  }
}

bool ModbusDevice::poll() {
  std::array<std::uint8_t, longest_answer> frame{};
  std::array<std::uint16_t, MODBUS_MAX_READ_REGISTERS> words{};
  for (std::size_t r = 0; r < requests_.size(); ++r) {
    const ReadRequest& request = requests_[r];
    CheckedAnswer answer;
    const ReadQuestion question{++transaction_, static_cast<std::uint8_t>(plan_.unit), request.table, request.address,
                                request.count};
    if (!ask(question, frame, answer)) return false;
    note_refused(r, answer.exception);
    if (answer.is == Answer::refused) continue;
    for (std::size_t i = 0; i < request.count; ++i) words[i] = word_of(frame, i);
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

/// One line per change and per new reason, of a device that comes and goes a few in a minute.
void ModbusDevice::note_connected(bool connected) {
  frame_.connected = connected;
  frames_.write(frame_);
  if (said_connected_ == connected && (connected || said_reason_ == reason_)) return;
  const auto before = changes_.pass(clock_.now_ns());
  if (!before) return;
  said_connected_ = connected;
  said_reason_ = reason_;
  if (connected) {
    spdlog::info("device {}:{} answers{}", plan_.address, plan_.port, LogLimit::also(*before));
  } else {
    spdlog::warn("device {}:{} does not answer ({}); trying on{}", plan_.address, plan_.port, reason_,
                 LogLimit::also(*before));
  }
}

void ModbusDevice::run(const std::atomic<bool>& stop) {
  const auto period_ns = static_cast<std::int64_t>(1e9 * plan_.poll_s);
  int failures = 0;
  while (!stop.load(std::memory_order_relaxed)) {
    if (connect()) {
      std::int64_t due_ns = clock_.now_ns();
      while (!stop.load(std::memory_order_relaxed) && poll()) {
        failures = 0;
        note_connected(true);
        due_ns = std::max(due_ns + period_ns, clock_.now_ns());
        sleep_until(due_ns, stop);
      }
    } else {
      reason_ = modbus_strerror(errno);
    }
    if (stop.load(std::memory_order_relaxed)) return;
    note_connected(false);
    context_.reset();
    sleep_until(clock_.now_ns() + static_cast<std::int64_t>(1e9 * back_off_s(failures++)), stop);
  }
}

}  // namespace spindle_twin::firmware

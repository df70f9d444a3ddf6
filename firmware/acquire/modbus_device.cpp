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

#include "firmware/acquire/read_address.hpp"

namespace spindle_twin::firmware {

struct ModbusDevice::Context {
  explicit Context(const ModbusPlan& plan) : modbus(modbus_new_tcp(plan.address.c_str(), plan.port)) {
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

namespace {

std::string place_of(const RegisterSource& source) {
  return (source.table == RegisterTable::input ? "input register " : "holding register ") +
         std::to_string(source.address);
}

/// Two channels may read the same registers, or none in common: one word is not of two numbers.
void refuse_overlap(const rom::TomlTable& table, const char* key, const RegisterSource& source,
                    const std::vector<RegisterSource>& others) {
  const auto end = [](const RegisterSource& of) { return of.address + words_of(of.type); };
  for (const RegisterSource& other : others) {
    const bool same = other.address == source.address && end(other) == end(source);
    if (same || other.table != source.table || source.address >= end(other) || other.address >= end(source)) continue;
    table.fail(key, place_of(source) + " has a word in common with the number of " +
                        std::to_string(words_of(other.type)) + (words_of(other.type) == 1 ? " word" : " words") +
                        " that another channel reads from " + place_of(other));
  }
}

}  // namespace

ChannelSource ModbusPlan::add_channel(const rom::TomlTable& table) {
  if (preset != nullptr && !table.has("register")) {
    RegisterSource source = preset->first;
    const auto channel = table.integer("channel", 0, preset->channels - 1);
    source.address = static_cast<std::uint16_t>(source.address + channel * words_of(source.type));
    refuse_overlap(table, "channel", source, sources);
    sources.push_back(source);
    return {preset->scale, true, place_of(source)};
  }
  RegisterSource source;
  source.address = static_cast<std::uint16_t>(table.integer("register", 0, 65534));
  source.table = table.choice_or("table", "input", {"input", "holding"}) == "input" ? RegisterTable::input
                                                                                    : RegisterTable::holding;
  source.type = *register_type_of(
      table.choice_or("type", "int16", {"int16", "uint16", "offset16", "int32", "uint32", "float32", "float32_cdab"}));
  refuse_overlap(table, "register", source, sources);
  sources.push_back(source);
  return {1.0, source.type != RegisterType::float32 && source.type != RegisterType::float32_cdab, place_of(source)};
}

std::unique_ptr<Driver> ModbusPlan::make_driver(Clock& clock) const {
  return std::make_unique<ModbusDevice>(*this, clock);
}

std::shared_ptr<DriverPlan> read_modbus_plan(const rom::TomlTable& device) {
  const auto plan = std::make_shared<ModbusPlan>();
  plan->address = read_ipv4(device, plan->address);
  plan->port = static_cast<int>(device.integer_or("port", plan->port, 1, 65535));
  plan->unit = static_cast<int>(device.integer_or("unit", plan->unit, 0, 255));
  plan->timeout_s = device.number_or("timeout_s", plan->timeout_s, rom::between(0.01, 10.0));
  if (device.has("preset")) plan->preset = &preset_of(device.choice("preset", preset_names()));
  return plan;
}

ModbusDevice::ModbusDevice(const ModbusPlan& plan, Clock& clock)
    : plan_(plan), clock_(clock), requests_(plan_requests(plan_.sources)), refused_(requests_.size(), 0) {}

ModbusDevice::~ModbusDevice() = default;

bool ModbusDevice::connect() {
  context_ = std::make_unique<Context>(plan_);
  if (modbus_connect(context_->modbus) == 0) return true;
  reason_ = modbus_strerror(errno);
  return false;
}

/// False where the connection is of no more use; reason_ says why.
bool ModbusDevice::ask(const ReadQuestion& question, std::span<std::uint8_t> frame, CheckedAnswer& answer) {
  const int socket = modbus_get_socket(context_->modbus);
  const std::int64_t deadline_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * plan_.timeout_s);
  const auto sent = encode(question);
  if (send(socket, sent.data(), sent.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(sent.size())) {
    reason_ = std::strerror(errno);
    return false;
  }
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
    // What came while the process stood still is no reading of now.
    answered_ns_ = clock_.now_ns();
    if (answered_ns_ > deadline_ns) {
      reason_ = "no answer in time";
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

bool ModbusDevice::poll(DeviceReadings& readings) {
  std::array<std::uint8_t, longest_answer> frame{};
  std::array<std::uint16_t, MODBUS_MAX_READ_REGISTERS> words{};
  for (std::size_t r = 0; r < requests_.size(); ++r) {
    const ReadRequest& request = requests_[r];
    CheckedAnswer answer;
    const ReadQuestion question{++transaction_, static_cast<std::uint8_t>(plan_.unit), request.table, request.address,
                                request.count};
    if (!ask(question, frame, answer)) {
      readings.refuse();
      return false;
    }
    note_refused(r, answer.exception);
    if (answer.is == Answer::refused) {
      readings.refuse();
      continue;
    }
    readings.accept();
    for (std::size_t i = 0; i < request.count; ++i) words[i] = word_of(frame, i);
    for (const std::size_t channel : request.channels) {
      const RegisterSource& source = plan_.sources[channel];
      const std::size_t at = static_cast<std::size_t>(source.address - request.address);
      readings.take(channel, decode(source, std::span(words).subspan(at)), answered_ns_);
    }
  }
  return true;
}

Step ModbusDevice::step(DeviceReadings& readings) {
  if ((context_ != nullptr || connect()) && poll(readings)) return {};
  context_.reset();
  return {Step::Is::lost, reason_};
}

}  // namespace spindle_twin::firmware

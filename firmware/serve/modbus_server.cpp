#include "firmware/serve/modbus_server.hpp"

#include <netinet/tcp.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <new>
#include <utility>

#include "firmware/serve/command_registers.hpp"
#include "firmware/serve/device_identification.hpp"
#include "firmware/serve/listen.hpp"

namespace spindle_twin::firmware {
namespace {

/// libmodbus keeps descriptors in an fd_set.
constexpr int descriptor_limit = 1024;

/// Answers that a client may leave unread: dozens of the longest, for those that ask several things at once.
constexpr int unread_bytes = 16384;

constexpr std::int64_t may_be_evicted_ns = 5 * ns_per_s;  ///< a connection that is idle for so long

void notify(const Descriptor& event) {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(event.get(), &one, sizeof one);
}

bool can_take_an_answer(int socket) {
  pollfd writable{socket, POLLOUT, 0};
  return poll(&writable, 1, 0) == 1 && (writable.revents & POLLOUT) != 0;
}

}  // namespace

ModbusServer::ModbusServer(const ServePlan& plan, Clock& clock, const std::vector<SpindlePorts>& spindles)
    : plan_(plan),
      clock_(clock),
      acceptor_(Descriptor(plan.plain ? listen_on(plan.address, plan.port) : -1), plan.allow, clock, "server",
                "serve.allow"),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      adopting_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      modbus_(modbus_new_tcp(nullptr, 0), modbus_free) {
  if (modbus_ == nullptr || wake_.get() < 0 || adopting_.get() < 0) throw std::bad_alloc();
  // libmodbus sleeps for the response timeout before some of its exceptions; a whole frame is there, so the byte
  // timeout has nothing to wait for either.
  modbus_set_response_timeout(modbus_.get(), 0, 1);
  modbus_set_byte_timeout(modbus_.get(), 0, 0);
  modbus_set_indication_timeout(modbus_.get(), 0, 1000);
  modbus_set_error_recovery(modbus_.get(), MODBUS_ERROR_RECOVERY_NONE);
  connections_.reserve(static_cast<std::size_t>(plan.connections));
  spindles_.reserve(spindles.size());
  for (const SpindlePorts& ports : spindles) {
    spindles_.emplace_back(ports, clock);
    units_ |= ports.units;
  }
}

int ModbusServer::port() const { return acceptor_.port(); }

void ModbusServer::stop() { notify(wake_); }

void ModbusServer::adopt(Descriptor socket, std::uint32_t host, bool may_write) {
  {
    const std::lock_guard lock(guard_);
    adopted_.push_back({std::move(socket), host, may_write});
  }
  notify(adopting_);
}

bool ModbusServer::order(std::size_t spindle, const Order& order) {
  constexpr std::chrono::seconds patience(2);
  std::future<bool> taken;
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(guard_);
    number = ++asked_last_;
    asked_.push_back({number, spindle, order, {}});
    taken = asked_.back().taken.get_future();
  }
  notify(adopting_);
  if (taken.wait_for(patience) == std::future_status::ready) return taken.get();
  // What is taken back here is not obeyed later; what is under way already is waited for.
  const std::lock_guard lock(guard_);
  return std::erase_if(asked_, [number](const Asked& each) { return each.number == number; }) == 0 && taken.get();
}

int ModbusServer::poll_timeout_ms() const {
  std::int64_t first_ns = 0;
  const auto take = [&](std::int64_t time_ns) { first_ns = first_ns == 0 ? time_ns : std::min(first_ns, time_ns); };
  for (const Connection& connection : connections_) {
    if (connection.deadline_ns != 0) take(connection.deadline_ns);
    take(connection.asked_ns + idle_ns());
  }
  if (acceptor_.rests_until_ns() != 0) take(acceptor_.rests_until_ns());
  if (first_ns == 0) return -1;
  return static_cast<int>(std::max<std::int64_t>(0, (first_ns - clock_.now_ns()) / 1'000'000 + 1));
}

void ModbusServer::run() {
  std::vector<pollfd> polled;
  constexpr std::size_t first_client = 3;
  polled.reserve(connections_.capacity() + first_client);
  while (true) {
    polled.clear();
    polled.push_back({wake_.get(), POLLIN, 0});
    polled.push_back(acceptor_.polled());
    polled.push_back({adopting_.get(), POLLIN, 0});
    for (const Connection& connection : connections_)
      polled.push_back({connection.socket.get(), POLLIN | POLLRDHUP, 0});
    if (poll(polled.data(), polled.size(), poll_timeout_ms()) < 0 && errno != EINTR) {
      acceptor_.rest_behind_failed_poll(errno);
      for (pollfd& each : polled) each.revents = 0;
    }
    if (polled[0].revents != 0) return;
    const std::int64_t now_ns = clock_.now_ns();
    for (std::size_t c = 0; c < connections_.size(); ++c) {
      Connection& connection = connections_[c];
      if (polled[c + first_client].revents != 0) look_at(connection, polled[c + first_client].revents);
      if (connection.deadline_ns != 0 && now_ns >= connection.deadline_ns) connection.open = false;
      if (now_ns - connection.asked_ns >= idle_ns()) connection.open = false;
    }
    std::erase_if(connections_, [](const Connection& connection) { return !connection.open; });
    if (polled[1].revents != 0) accept_all();
    if (polled[2].revents != 0) adopt_all();
  }
}

void ModbusServer::adopt_all() {
  std::uint64_t count = 0;
  [[maybe_unused]] const ssize_t cleared = ::read(adopting_.get(), &count, sizeof count);
  std::vector<Newcomer> adopted;
  {
    const std::lock_guard lock(guard_);
    adopted.swap(adopted_);
    for (Asked& each : asked_) each.taken.set_value(spindles_[each.spindle].take(each.order));
    asked_.clear();
  }
  for (Newcomer& each : adopted) admit(std::move(each));
}

void ModbusServer::accept_all() {
  while (auto client = acceptor_.next()) {
    admit({std::move(client->socket), client->host, is_allowed(plan_.write, client->host)});
  }
}

void ModbusServer::admit(Newcomer newcomer) {
  const int socket = newcomer.socket.get();
  const std::int64_t now_ns = clock_.now_ns();
  if (socket >= descriptor_limit || !make_room_for(newcomer.host)) {
    const auto before = refusals_.pass(now_ns);
    if (before) {
      const char* why = socket >= descriptor_limit ? "no file descriptor below 1024 is free" : "none is idle for long";
      spdlog::warn("client {} refused: {} connections are open, {}{}", address_text(newcomer.host), connections_.size(),
                   why, LogLimit::also(*before));
    }
    return;
  }
  limit_unread(socket, unread_bytes);
  Connection& connection = connections_.emplace_back();
  connection.socket = std::move(newcomer.socket);
  connection.host = newcomer.host;
  connection.may_write = newcomer.may_write;
  connection.asked_ns = now_ns;
  connection.talks.resize(spindles_.size());
}

/// Closes the longest idle connection, of the same address where that has all it may have; false where none is idle.
bool ModbusServer::make_room_for(std::uint32_t host) {
  const auto of_host = [&](const Connection& connection) { return connection.host == host; };
  const auto from_host = std::count_if(connections_.begin(), connections_.end(), of_host);
  const bool host_is_full = from_host >= plan_.connections_per_host;
  if (!host_is_full && connections_.size() < static_cast<std::size_t>(plan_.connections)) return true;
  auto longest = connections_.end();
  for (auto each = connections_.begin(); each != connections_.end(); ++each) {
    if (host_is_full && each->host != host) continue;
    if (longest == connections_.end() || each->asked_ns < longest->asked_ns) longest = each;
  }
  if (longest == connections_.end() || clock_.now_ns() - longest->asked_ns < may_be_evicted_ns) return false;
  connections_.erase(longest);
  return true;
}

/// `to`: the spindle that the request has told these signals. Who talks to one spindle is there for the others too.
void ModbusServer::note_request(Connection& connection, const SpindleRegisters* to, SignalSet told) {
  connection.asked_ns = clock_.now_ns();
  for (std::size_t s = 0; s < spindles_.size(); ++s) {
    spindles_[s].note_request(connection.talks[s], &spindles_[s] == to ? told : SignalSet());
  }
}

/// The gate has let only units of spindles pass.
SpindleRegisters& ModbusServer::spindle_of(std::uint8_t unit) {
  return *std::find_if(spindles_.begin(), spindles_.end(),
                       [&](const SpindleRegisters& each) { return each.units().test(unit); });
}

void ModbusServer::await(Connection& connection, std::size_t bytes) {
  // The bytes stay in the socket until the frame is whole, so without the mark poll() would report them again at once.
  if (connection.awaited == bytes) return;
  const int mark = static_cast<int>(bytes);
  setsockopt(connection.socket.get(), SOL_SOCKET, SO_RCVLOWAT, &mark, sizeof mark);
  connection.awaited = bytes;
}

void ModbusServer::look_at(Connection& connection, short events) {
  const int fd = connection.socket.get();
  std::array<std::uint8_t, longest_frame> frame{};
  int pending = 0;
  if ((events & (POLLERR | POLLNVAL)) != 0 || ioctl(fd, FIONREAD, &pending) != 0 || pending <= 0) {
    connection.open = false;
    return;
  }
  const ssize_t peeked = recv(fd, frame.data(), std::min(frame.size(), static_cast<std::size_t>(pending)), MSG_PEEK);
  if (peeked <= 0) {
    connection.open = peeked < 0 && errno == EAGAIN;
    return;
  }
  const auto received = std::span<const std::uint8_t>(frame).first(static_cast<std::size_t>(peeked));
  const WriteRange commands = writable_registers();
  const Gate gate = judge_frame(received, connection.may_write ? commands : WriteRange{}, commands, units_);
  if (gate.verdict == Verdict::wait) {
    if ((events & (POLLRDHUP | POLLHUP)) != 0) connection.open = false;  // the rest will never come
    if (connection.deadline_ns == 0) {
      connection.deadline_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * plan_.frame_deadline_s);
    }
    await(connection, gate.bytes);
    return;
  }
  connection.deadline_ns = 0;
  await(connection, 1);
  if (gate.verdict == Verdict::close || !can_take_an_answer(fd)) {
    connection.open = false;
    return;
  }
  answer(connection, gate, received.first(gate.bytes));
}

void ModbusServer::answer(Connection& connection, const Gate& gate, std::span<const std::uint8_t> frame) {
  const int fd = connection.socket.get();
  if (gate.verdict == Verdict::hand_over) {
    connection.open = hand_over(connection, gate, unit_of(frame));
    return;
  }
  note_request(connection);
  std::array<std::uint8_t, longest_frame> taken{};
  if (recv(fd, taken.data(), frame.size(), 0) != static_cast<ssize_t>(frame.size())) {
    connection.open = false;
    return;
  }
  if (gate.verdict == Verdict::identify) {
    const std::vector<std::uint8_t> reply = identify_device(frame);
    connection.open = send(fd, reply.data(), reply.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(reply.size());
  } else {
    // libmodbus adds 0x80 to the function, which would turn one that has the bit already into another's answer.
    taken[mbap_bytes] &= 0x7FU;
    modbus_set_socket(modbus_.get(), fd);
    connection.open = modbus_reply_exception(modbus_.get(), taken.data(), gate.exception) > 0;
  }
}

bool ModbusServer::hand_over(Connection& connection, const Gate& gate, std::uint8_t unit) {
  modbus_set_socket(modbus_.get(), connection.socket.get());
  std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> query{};
  const int length = modbus_receive(modbus_.get(), query.data());
  if (length <= 0) return false;
  SpindleRegisters& spindle = spindle_of(unit);
  if (!spindle.has_room_for(gate.write)) {
    note_request(connection);
    return modbus_reply_exception(modbus_.get(), query.data(), MODBUS_EXCEPTION_SLAVE_OR_SERVER_BUSY) > 0;
  }
  const int sent = modbus_reply(modbus_.get(), query.data(), length, spindle.renew());
  constexpr int exception_bytes = 9;
  const bool wrote = gate.write.count > 0 && sent > exception_bytes;
  note_request(connection, &spindle, wrote ? spindle.take(gate.write) : SignalSet());
  return sent > 0;
}

}  // namespace spindle_twin::firmware

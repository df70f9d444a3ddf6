#include <algorithm>
#include <array>
#include <cstddef>
#include <random>

#include "tests/bench/modbus_loading/clients.hpp"

namespace spindle_twin::load {
namespace {

using Random = std::mt19937_64;

std::uint8_t byte(int value) { return static_cast<std::uint8_t>(value); }

int between(Random& random, int least, int most) { return std::uniform_int_distribution<int>(least, most)(random); }

/// A frame that is one, but must be refused, and by which exception.
struct Refused {
  Bytes pdu;
  std::uint8_t unit = 1;
  std::uint8_t exception = 0;
};

Refused refused_frame(Random& random) {
  const auto any = [&] { return byte(between(random, 0, 255)); };
  switch (between(random, 0, 6)) {
    case 0: {  // a function that is not served, with anything behind it
      constexpr std::array<std::uint8_t, 12> functions{0, 1, 2, 5, 7, 8, 15, 17, 24, 65, 100, 127};
      Bytes pdu{functions[static_cast<std::size_t>(between(random, 0, 11))]};
      for (int n = between(random, 0, 252); n > 0; --n) pdu.push_back(any());
      return {pdu, 1, 1};
    }
    case 1: {  // more than a read may ask for, or nothing
      const int quantity = between(random, 0, 1) == 0 ? 0 : between(random, 126, 65535);
      return {{byte(between(random, 3, 4)), any(), any(), byte(quantity >> 8), byte(quantity & 255)}, 1, 3};
    }
    case 2: {  // too short or too long for its function
      Bytes pdu{4, 0, 0, 0, 1, 0, 0, 0, 0};
      pdu.resize(
          static_cast<std::size_t>(std::array{1, 2, 3, 4, 6, 7, 9}[static_cast<std::size_t>(between(random, 0, 6))]));
      return {pdu, 1, 3};
    }
    case 3:  // a byte count that contradicts the quantity
      return {{16, 3, 0xE8, 0, byte(between(random, 2, 123)), 2, any(), any()}, 1, 3};
    case 4:  // a write of what is published
      return {{6, 0, any(), any(), any()}, 1, 2};
    case 5:  // a read beyond the end
      return {
          {byte(between(random, 3, 4)), byte(between(random, 7, 255)), any(), 0, byte(between(random, 1, 125))}, 1, 2};
    default:  // another unit
      return {{4, any(), any(), any(), any()}, byte(between(random, 2, 254)), 11};
  }
}

/// What cannot be the front of a request: the server must end the connection.
Bytes ending_frame(Random& random) {
  Bytes frame = framed(1, {4, 0, 0, 0, 1});
  switch (between(random, 0, 3)) {
    case 0:
      frame[static_cast<std::size_t>(between(random, 2, 3))] = byte(between(random, 1, 255));
      break;
    case 1:
      frame[5] = byte(between(random, 0, 1));
      break;
    case 2:
      frame[4] = byte(between(random, 1, 255));
      break;
    default:
      return {'G', 'E', 'T', ' ', '/', ' ', 'H', 'T', 'T', 'P', '/', '1', '.', '1', '\r', '\n'};
  }
  return frame;
}

bool is_refusal(const Bytes& frame, std::uint16_t transaction, const Refused& asked) {
  return frame.size() == 9 && (frame[0] << 8 | frame[1]) == transaction && frame[6] == asked.unit &&
         frame[7] == (asked.pdu[0] | 0x80) && frame[8] == asked.exception;
}

/// One connection that says what is wrong: some frames that are refused, then one that ends it.
class Offender {
 public:
  Offender(int port, std::uint64_t seed) : port_(port), random_(seed) {}

  const Connection& connection() const { return connection_; }

  /// Does what there is to do; the number of frames that it has sent, at the most `most` of them.
  long step(long most, MalformedScore& score) {
    const long before = score.frames;
    if (!connection_.is_open()) {
      connection_.open(port_);
      to_refuse_ = between(random_, 0, 15);
    }
    if (waits_ && !settle(score)) return 0;
    if (connection_.is_open() && most > 0) say(score);
    return score.frames - before;
  }

 private:
  void say(MalformedScore& score) {
    since_ns_ = now_ns();
    waits_ = true;
    ++score.frames;
    if (to_refuse_ > 0) {
      asked_ = refused_frame(random_);
      connection_.send(framed(++transaction_, asked_.pdu, asked_.unit));
    } else if (between(random_, 0, 3) == 0) {
      const Bytes whole = framed(1, {4, 0, 0, 0, 1});
      connection_.send(std::span(whole).first(static_cast<std::size_t>(between(random_, 1, 11))));
      connection_.close();
      ++score.cut;
      waits_ = false;
    } else {
      connection_.send(ending_frame(random_));
    }
  }

  /// True once the server has said what it has to say to the last frame.
  bool settle(MalformedScore& score) {
    const bool ended = !connection_.receive();
    const auto frame = connection_.next_frame();
    const bool late = now_ns() - since_ns_ > patience_ns;
    if (!ended && !frame && !late) return false;
    waits_ = false;
    if (to_refuse_ > 0 && frame && is_refusal(*frame, transaction_, asked_)) {
      ++score.refused;
    } else if (to_refuse_ == 0 && ended && !frame) {
      ++score.ended;
    } else {
      ++score.wrong;
    }
    if (ended || late) connection_.close();
    --to_refuse_;
    return true;
  }

  int port_;
  Random random_;
  Connection connection_;
  Refused asked_;
  std::int64_t since_ns_ = 0;
  std::uint16_t transaction_ = 0;
  int to_refuse_ = 0;
  bool waits_ = false;
};

/// A client that is slow to send, or slow to read.
struct Slow {
  Connection connection;
  bool reads_nothing = false;
  std::int64_t next_ns = 0;
  std::size_t sent = 0;
};

constexpr std::int64_t drip_ns = 3 * ns_per_s / 10;
constexpr std::int64_t unread_ns = ns_per_s / 50;

void act(Slow& client, int port, SlowScore& score) {
  const Bytes request = framed(1, {4, 0, 0, 0, 125});
  if (!client.connection.is_open()) {
    client.connection.open(port, client.reads_nothing ? 2048 : 0);
    client.sent = 0;
  }
  if (client.reads_nothing) {
    client.next_ns += unread_ns;
    for (int n = 0; n < 8; ++n) {
      if (!client.connection.send(request)) {
        client.connection.close();
        ++score.ended_unread;
        return;
      }
      ++score.unread_requests;
    }
    return;
  }
  client.next_ns += drip_ns;
  const bool goes_on = client.connection.receive() &&
                       client.connection.send(std::span(request).subspan(client.sent % request.size(), 1));
  ++client.sent;
  ++score.bytes_dripped;
  if (goes_on) return;
  client.connection.close();
  ++score.ended_drips;
}

}  // namespace

SlowScore run_slow(int port, int connections, const std::atomic<bool>& stop) {
  SlowScore score;
  std::vector<Slow> clients(static_cast<std::size_t>(connections));
  for (std::size_t c = 0; c < clients.size(); ++c) {
    clients[c].reads_nothing = c % 8 == 7;
    clients[c].next_ns = now_ns() + static_cast<std::int64_t>(c) * drip_ns / connections;
  }
  while (!stop) {
    const auto next = std::min_element(clients.begin(), clients.end(),
                                       [](const Slow& a, const Slow& b) { return a.next_ns < b.next_ns; });
    wait_for({}, next->next_ns);
    act(*next, port, score);
  }
  return score;
}

MalformedScore run_malformed(int port, long frames, double per_s, std::uint64_t seed) {
  constexpr std::size_t connections = 8;
  MalformedScore score;
  std::vector<Offender> offenders;
  for (std::size_t c = 0; c < connections; ++c) offenders.emplace_back(port, seed + c);
  std::array<const Connection*, connections> waited{};
  for (std::size_t c = 0; c < connections; ++c) waited[c] = &offenders[c].connection();
  const std::int64_t start_ns = now_ns();
  while (score.refused + score.ended + score.cut + score.wrong < frames) {
    const double passed_s = 1e-9 * static_cast<double>(now_ns() - start_ns);
    long due = std::min(frames, static_cast<long>(per_s * passed_s) + 1) - score.frames;
    long sent = 0;
    for (Offender& offender : offenders) sent += offender.step(due - sent, score);
    if (sent == 0) wait_for(waited, now_ns() + ns_per_s / 1000);
  }
  return score;
}

}  // namespace spindle_twin::load

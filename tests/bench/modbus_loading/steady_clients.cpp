#include <algorithm>
#include <array>
#include <cstddef>

#include "tests/bench/modbus_loading/clients.hpp"

namespace spindle_twin::load {
namespace {

constexpr std::size_t mbap_bytes = 7;

/// A client that behaves, and its request: on its way since sent_ns (0: none is), due at due_ns.
struct Steady {
  Connection connection;
  Bytes pdu;
  std::int64_t due_ns = 0;
  std::int64_t sent_ns = 0;
  std::uint16_t transaction = 0;
};

/// The answer to a read of the block `prediction` begins with its two known words; any other read has its length.
bool answers(const Bytes& request, std::uint16_t transaction, const Bytes& frame) {
  if (frame.size() < mbap_bytes + 2 || (frame[0] << 8 | frame[1]) != transaction || frame[7] != request[0])
    return false;
  if (request[0] == 16) return std::equal(request.begin(), request.begin() + 5, frame.begin() + mbap_bytes);
  constexpr std::array<std::uint8_t, 4> known{0x12, 0x34, 0xFF, 0x83};
  const bool is_prediction = request[1] == 0 && request[2] == 0;
  return frame.size() == mbap_bytes + 2 + 2U * request[4] && frame[8] == 2 * request[4] &&
         (!is_prediction || std::equal(known.begin(), known.end(), frame.begin() + 9));
}

void ask(Steady& client, Answers& score) {
  client.sent_ns = now_ns();
  ++score.requests;
  if (!client.connection.send(framed(++client.transaction, client.pdu))) client.connection.close();
}

/// Takes an answer that has come; true where it has.
bool take(Steady& client, Answers& score) {
  if (client.sent_ns == 0) return false;
  const bool ended = !client.connection.is_open() || !client.connection.receive();
  const auto frame = client.connection.next_frame();
  if (!frame && !ended && now_ns() - client.sent_ns < patience_ns) return false;
  if (!frame) {
    ++score.missing;
    client.connection.close();
  } else if (!answers(client.pdu, client.transaction, *frame)) {
    ++score.wrong;
  }
  score.latency_ms.push_back(static_cast<float>(1e-6 * static_cast<double>(now_ns() - client.due_ns)));
  client.sent_ns = 0;
  return true;
}

}  // namespace

Answers run_readers(int port, int connections, double per_s, const std::atomic<bool>& stop) {
  Answers score;
  std::vector<Steady> clients(static_cast<std::size_t>(connections));
  std::vector<const Connection*> waited;
  const auto beat_ns = static_cast<std::int64_t>(1e9 * connections / per_s);
  const std::int64_t start_ns = now_ns();
  for (std::size_t c = 0; c < clients.size(); ++c) {
    const auto function = static_cast<std::uint8_t>(c % 2 == 0 ? 4 : 3);
    clients[c].pdu = {function, 0, 0, 0, 124};
    clients[c].connection.open(port);
    clients[c].due_ns = start_ns + static_cast<std::int64_t>(c) * beat_ns / connections;
    waited.push_back(&clients[c].connection);
  }
  bool on_its_way = true;
  while (!stop || on_its_way) {
    std::int64_t next_ns = now_ns() + ns_per_s / 10;
    on_its_way = false;
    for (Steady& client : clients) {
      if (take(client, score)) client.due_ns += beat_ns;
      if (client.sent_ns == 0 && !stop && client.due_ns <= now_ns()) {
        if (!client.connection.is_open()) client.connection.open(port);
        ask(client, score);
      }
      if (client.sent_ns == 0) next_ns = std::min(next_ns, client.due_ns);
      on_its_way = on_its_way || client.sent_ns != 0;
    }
    wait_for(waited, next_ns);
  }
  return score;
}

Answers run_plc(int port, const std::atomic<bool>& stop) {
  constexpr std::int64_t beat_ns = ns_per_s / 10;
  const Bytes write_signals{16, 3, 0xE8, 0, 2, 4, 0x17, 0x70, 0x01, 0xF4};
  const Bytes read_compensation{4, 5, 0xDC, 0, 30};
  Answers score;
  Steady plc;
  plc.connection.open(port);
  const std::array<const Connection*, 1> waited{&plc.connection};
  for (std::int64_t beat_at_ns = now_ns(); !stop; beat_at_ns = std::max(beat_at_ns + beat_ns, now_ns())) {
    wait_for({}, beat_at_ns);
    for (const Bytes& pdu : {write_signals, read_compensation}) {
      if (!plc.connection.is_open()) plc.connection.open(port);
      plc.pdu = pdu;
      plc.due_ns = now_ns();
      ask(plc, score);
      while (!take(plc, score)) wait_for(waited, now_ns() + ns_per_s);
    }
  }
  return score;
}

}  // namespace spindle_twin::load

#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "tests/bench/modbus_loading/connection.hpp"

/// Clients of all manners against one Modbus server; each function runs until `stop` and, unless it says otherwise,
/// counts only. They throw std::runtime_error where nobody listens any more.
namespace spindle_twin::load {

/// What clients that behave got for their requests.
struct Answers {
  long requests = 0;
  long wrong = 0;                 ///< not what was asked for
  long missing = 0;               ///< none within patience_ns, or the connection ended
  std::vector<float> latency_ms;  ///< from when the request was due, so that what queues up counts
};

/// So many connections that together read 124 registers `per_s` times a second, each on its own beat.
Answers run_readers(int port, int connections, double per_s, const std::atomic<bool>& stop);

/// A PLC: each 100 ms it writes two signals and reads the compensation.
Answers run_plc(int port, const std::atomic<bool>& stop);

struct SlowScore {
  long bytes_dripped = 0;
  long ended_drips = 0;  ///< connections that the server ended at its deadline
  long unread_requests = 0;
  long ended_unread = 0;  ///< connections that the server ended because nobody took its answers
};

/// Connections that send a byte now and then; every eighth asks on and on and reads nothing.
SlowScore run_slow(int port, int connections, const std::atomic<bool>& stop);

struct MalformedScore {
  long frames = 0;
  long refused = 0;  ///< answered by the exception that they deserve
  long ended = 0;    ///< ended by the server, where where the next frame begins would be a guess
  long cut = 0;      ///< ended by the client in the middle of a frame
  long wrong = 0;    ///< anything else
};

/// So many malformed frames from eight connections, not faster than per_s; ends with the last one.
MalformedScore run_malformed(int port, long frames, double per_s, std::uint64_t seed);

}  // namespace spindle_twin::load

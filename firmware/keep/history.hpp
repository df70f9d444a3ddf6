#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "firmware/cycle/cycle.hpp"
#include "rom/network.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {

/// The header and one row of the history: a CSV with a row per cycle, temperatures in degC, lengths in um, empty
/// fields for values that do not exist. Readings and signals to the last bit, as `spindle-twin replay` reads them back.
std::string history_header(const rom::Network& network);
std::string history_row(const Snapshot& snapshot);

/// Writes each cycle's snapshot as a row, in the thread that calls run(); the cycle thread only fills the ring.
class History {
 public:
  /// Begins the file anew. Throws rom::InputError naming the path if it cannot be written.
  History(const std::string& path, const rom::Network& network);

  SnapshotRing& ring() { return ring_; }
  std::atomic<std::uint64_t>& lost() { return lost_; }

  /// Until `stop` is set; what is in the ring then is still written.
  void run(const std::atomic<bool>& stop);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void drain();

  std::unique_ptr<std::FILE, Close> file_;
  std::string path_;
  SnapshotRing ring_;
  std::atomic<std::uint64_t> lost_{0};
};

}  // namespace spindle_twin::firmware

#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

/// What the threads beside the cycle cannot do, for the registers. Any thread; nobody waits.
class Troubles {
 public:
  void set(Fault fault, bool holds) {
    if (holds) {
      faults_.fetch_or(bits(fault), std::memory_order_relaxed);
    } else {
      faults_.fetch_and(static_cast<std::uint16_t>(~bits(fault)), std::memory_order_relaxed);
    }
  }
  std::uint16_t faults() const { return faults_.load(std::memory_order_relaxed); }

  std::atomic<std::uint64_t> history_rows_lost{0};
  const std::atomic<std::uint64_t>* log_lines_dropped = nullptr;  ///< of the whole program; null: nobody counts

 private:
  std::atomic<std::uint16_t> faults_{0};
};

}  // namespace spindle_twin::firmware

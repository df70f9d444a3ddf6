#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>

#include "firmware/plant/plant_metrics.hpp"

namespace spindle_twin::firmware {

/// What one spindle said at one time.
struct PlantSample {
  std::size_t device = 0;
  std::uint64_t time_ms = 0;  ///< since 1970
  PlantValues values;         ///< in the order of its metrics
};

/// Samples on their way to the broker, oldest first: those that wait, and before them those that were sent and whose
/// arrival nobody has confirmed yet. Beyond its room the oldest that wait go, counted. For one thread.
class SampleQueue {
 public:
  explicit SampleQueue(std::size_t room) : room_(room) {}

  void push(PlantSample sample) {
    waiting_.push_back(std::move(sample));
    shorten();
  }

  /// The oldest `most` that wait are under way now. Nothing else may be.
  const std::deque<PlantSample>& send(std::size_t most) {
    while (!waiting_.empty() && sent_.size() < most) {
      sent_.push_back(std::move(waiting_.front()));
      waiting_.pop_front();
    }
    return sent_;
  }

  /// What is under way has arrived: how many.
  std::size_t confirm() {
    const std::size_t count = sent_.size();
    sent_.clear();
    return count;
  }

  /// Nobody knows whether it has: it is sent again.
  void take_back() {
    while (!sent_.empty()) {
      waiting_.push_front(std::move(sent_.back()));
      sent_.pop_back();
    }
    shorten();
  }

  std::size_t waiting() const { return waiting_.size(); }
  std::size_t under_way() const { return sent_.size(); }
  std::uint64_t dropped() const { return dropped_; }

 private:
  void shorten() {
    while (waiting_.size() > room_) {
      waiting_.pop_front();
      ++dropped_;
    }
  }

  std::size_t room_;
  std::deque<PlantSample> waiting_, sent_;
  std::uint64_t dropped_ = 0;
};

}  // namespace spindle_twin::firmware

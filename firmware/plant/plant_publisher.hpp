#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/plant/broker_link.hpp"
#include "firmware/plant/edge_node.hpp"
#include "firmware/plant/plant_plan.hpp"
#include "firmware/serve/descriptor.hpp"
#include "firmware/show/plant_counts.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

/// What the plant network is told of a spindle.
struct SpindleToPublish {
  std::string name;            ///< among several; empty: the only one
  ShownNames names;            ///< of its network
  double stale_after_s = 5.0;  ///< clock time; whose cycle is older than that says nothing any more
};

/// Publishes each spindle's numbers to the plant's broker, read-only, in the one thread that calls run(); the cycle
/// thread only leaves its snapshots.
class PlantPublisher {
 public:
  PlantPublisher(const PlantPlan& plan, const std::vector<SpindleToPublish>& spindles, Clock& clock);

  /// Of the spindle of this number; for its cycle.
  Latest<Snapshot>& tap(std::size_t spindle) { return spindles_[spindle]->tap; }
  const PlantCounts& counts() const { return counts_; }
  /// Until stop(); then the broker is told. A name server that does not answer delays the end by its own time limit.
  void run();
  /// Ends run(); from any thread.
  void stop();

 private:
  struct Spindle {
    double stale_after_s = 0.0;
    Latest<Snapshot> tap = {};
    Snapshot snapshot = {};
    std::uint64_t published = 0;  ///< number of the cycle
  };

  PlantTime now() const;
  void sample(const PlantTime& now);
  void wait(std::int64_t until_ns);

  const PlantPlan plan_;
  Clock& clock_;
  std::vector<std::unique_ptr<Spindle>> spindles_;
  EdgeNode node_;
  PlantCounts counts_;
  BrokerLink link_;
  Descriptor wake_;
  std::atomic<bool> stop_{false};
};

}  // namespace spindle_twin::firmware

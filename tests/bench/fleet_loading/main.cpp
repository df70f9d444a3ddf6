#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "firmware/cycle/publish.hpp"
#include "firmware/plant/broker_link.hpp"
#include "firmware/plant/edge_node.hpp"
#include "firmware/serve/fill_image.hpp"
#include "firmware/watch/clock.hpp"
#include "tests/bench/command_line/command_line.hpp"
#include "tests/firmware/support/small_network.hpp"

/// Many spindles that publish, each a daemon's own edge node, queue and connection, in one process. Says at the end, as
/// one line of JSON for each node, how many samples it made, how many its broker has read and how many it dropped.
namespace spindle_twin::firmware {
namespace {

struct Load {
  std::string host = "127.0.0.1";
  int port = 1883;
  std::size_t nodes = 100, first = 0;
  double period_s = 10.0, seconds = 60.0, connects_per_s = 500.0, patience_s = 120.0;
  int queue = 360;
};

const std::vector<std::string> registers = {"sequence",
                                            "state",
                                            "nose",
                                            "nose_sd",
                                            "nose_uncorrected",
                                            "compensation",
                                            "model_time",
                                            "speed",
                                            "load",
                                            "data_age",
                                            "key_point_count",
                                            "part_count",
                                            "coolant_temperature",
                                            "ambient_temperature",
                                            "displacement_innovation",
                                            "correction_enabled",
                                            "overruns",
                                            "key_point_predicted"};

std::vector<PlantDevice> one_device() {
  std::vector<PlantDevice> devices;
  devices.push_back({"spindle", std::make_unique<PlantMetrics>(names_of(tests::small_network()), registers)});
  return devices;
}

PlantPlan plan_of(const Load& load, std::size_t number) {
  PlantPlan plan;
  plan.host = load.host;
  plan.port = load.port;
  plan.group = "fleet";
  plan.node = "node_" + std::to_string(load.first + number);
  plan.queue = load.queue;
  return plan;
}

struct Node {
  Node(const Load& load, std::size_t number)
      : plan(plan_of(load, number)),
        edge(plan.group, plan.node, one_device(), static_cast<std::size_t>(load.queue)),
        link(plan, edge, counts) {}

  PlantPlan plan;
  EdgeNode edge;
  PlantCounts counts;
  BrokerLink link;
  std::int64_t sample_ns = 0;   ///< when the next is due
  std::int64_t connect_ns = 0;  ///< not before
  std::uint64_t made = 0;
};

PlantTime now() {
  static const MonotonicClock clock;
  return {clock.now_ns(), static_cast<std::uint64_t>(1000.0 * unix_now_s())};
}

/// A spindle that warms up, each another one.
PlantValues values_of(const Node& node, Snapshot& snapshot) {
  snapshot.sequence = node.made;
  const double rise = 1.0 - std::exp(-0.01 * static_cast<double>(node.made));
  snapshot.nose_m = 40e-6 * rise * (0.5 + 1e-4 * static_cast<double>(node.plan.node.size()));
  RegisterImage image{};
  fill_image(snapshot, snapshot.time_ns, image);
  return node.edge.metrics(0).values(image);
}

class Fleet {
 public:
  explicit Fleet(const Load& load) : load_(load), snapshot_(first_snapshot(tests::small_network())) {
    snapshot_.state = State::running;
    const std::int64_t start_ns = now().ns;
    for (std::size_t n = 0; n < load.nodes; ++n) {
      nodes_.push_back(std::make_unique<Node>(load, n));
      Node& node = *nodes_.back();
      const double turn = static_cast<double>(n) / static_cast<double>(load.nodes);
      node.connect_ns = start_ns + static_cast<std::int64_t>(1e9 * static_cast<double>(n) / load.connects_per_s);
      node.sample_ns = start_ns + static_cast<std::int64_t>(1e9 * load.period_s * turn);
    }
    polled_.resize(load.nodes);
    end_ns_ = start_ns + static_cast<std::int64_t>(1e9 * load.seconds);
  }

  /// Until all samples are made and have gone, or patience has.
  void run() {
    const std::int64_t last_ns = end_ns_ + static_cast<std::int64_t>(1e9 * load_.patience_s);
    while (true) {
      const PlantTime time = now();
      for (std::size_t n = 0; n < nodes_.size(); ++n) turn(*nodes_[n], polled_[n].revents != 0, time);
      if (time.ns > last_ns || (time.ns > end_ns_ && all_gone())) break;
      for (std::size_t n = 0; n < nodes_.size(); ++n) polled_[n] = nodes_[n]->link.waits_for();
      constexpr int wait_ms = 20;
      poll(polled_.data(), polled_.size(), wait_ms);
    }
    for (const auto& node : nodes_) {
      std::printf("{\"node\": \"%s\", \"made\": %llu, \"published\": %llu, \"dropped\": %llu}\n",
                  node->plan.node.c_str(), static_cast<unsigned long long>(node->made),
                  static_cast<unsigned long long>(node->counts.published.load()),
                  static_cast<unsigned long long>(node->counts.dropped.load()));
    }
  }

 private:
  void turn(Node& node, bool ready, const PlantTime& time) {
    const bool samples = time.ns >= node.sample_ns && time.ns <= end_ns_;
    if (samples) {
      ++node.made;
      node.edge.add(0, time.ms, values_of(node, snapshot_));
      node.sample_ns += static_cast<std::int64_t>(1e9 * load_.period_s);
    }
    if (time.ns < node.connect_ns) return;
    if (samples || ready || time.ns >= node.link.due_ns()) node.link.step(time);
  }

  bool all_gone() const {
    return std::all_of(nodes_.begin(), nodes_.end(), [](const auto& node) {
      return node->edge.queue().waiting() + node->edge.queue().under_way() == 0;
    });
  }

  const Load load_;
  Snapshot snapshot_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::vector<pollfd> polled_;
  std::int64_t end_ns_ = 0;
};

/// A connection of libmosquitto takes three descriptors.
void take_all_descriptors() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace
}  // namespace spindle_twin::firmware

int main(int argc, char** argv) {
  using namespace spindle_twin::firmware;
  try {
    spindle_twin::bench::CommandLine line("fleet_nodes: many spindles that publish to one broker");
    Load load;
    line.add("--port", load.port, "of the broker");
    line.require("--port");
    line.add("--nodes", load.nodes, "that publish");
    line.add("--first", load.first, "number of the first node");
    line.add("--period", load.period_s, "s from sample to sample");
    line.add("--seconds", load.seconds, "for which samples are made");
    line.add("--queue", load.queue, "samples that wait at most, of each");
    if (const auto code = line.parse(argc, argv)) return *code;
    take_all_descriptors();
    spdlog::set_level(spdlog::level::off);  // each node would say what happens to all
    Fleet(load).run();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fleet_nodes: %s\n", error.what());
    return 1;
  }
}

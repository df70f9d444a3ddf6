#pragma once

#include <poll.h>

#include <cstdint>
#include <memory>
#include <random>
#include <string>

#include "firmware/plant/edge_node.hpp"
#include "firmware/plant/plant_plan.hpp"
#include "firmware/show/plant_counts.hpp"
#include "firmware/watch/log_limit.hpp"

struct mosquitto;

namespace spindle_twin::firmware {

/// Both times of one moment: monotonic, and since 1970.
struct PlantTime {
  std::int64_t ns = 0;
  std::uint64_t ms = 0;
};

/// The connection of one edge node to its broker, by MQTT 5 and libmosquitto: begun again after a loss, first after
/// about a second, then twice as long up to half a minute, by chance somewhat longer or shorter, so that a thousand
/// daemons do not come at once. Data go by quality of service 0, as Sparkplug wants it, which nobody confirms; so the
/// node's subscription is renewed behind them, and the broker's answer to that says that it has read all before. What
/// is not confirmed within half a minute ends the connection and is sent again on the next one. Never waits, except for
/// a name server where `host` is a name. For one thread; allocates.
class BrokerLink {
 public:
  /// All must outlive this.
  BrokerLink(const PlantPlan& plan, EdgeNode& node, PlantCounts& counts);
  ~BrokerLink();
  BrokerLink(const BrokerLink&) = delete;
  BrokerLink& operator=(const BrokerLink&) = delete;

  /// Connects if it is time, reads and writes what is possible, sends what waits. Whenever waits_for() says so, and
  /// after a sample was added.
  void step(const PlantTime& now);
  /// What to wait for; descriptor −1: only for the time.
  pollfd waits_for() const;
  /// When a step is due whatever happens.
  std::int64_t due_ns() const { return due_ns_; }
  bool connected() const { return stage_ == Stage::connected; }
  /// Says that the node goes; the broker then publishes its death. Gives up after a second.
  void leave();

 private:
  enum class Stage { away, connecting, connected };
  struct Library;
  struct End {
    void operator()(mosquitto* session) const;
  };

  void connect(const PlantTime& now);
  bool prepare(const PlantTime& now);
  void read_and_write(const PlantTime& now);
  void greet(const PlantTime& now);
  void send(const PlantTime& now);
  bool publish(const std::vector<PlantMessage>& messages);
  void renew_subscription(const PlantTime& now);
  void lose(const PlantTime& now, const std::string& why);
  void count();
  std::string reason(int error) const;

  // Of the session's callbacks, which only note what they hear.
  void heard_connected(int code);
  void heard_disconnected(int code);
  void heard_message(const void* payload, int size);
  void heard_subscribed(int id, int granted);

  const PlantPlan& plan_;
  EdgeNode& node_;
  PlantCounts& counts_;
  std::unique_ptr<mosquitto, End> session_;
  Stage stage_ = Stage::away;
  std::int64_t due_ns_ = 0;
  std::int64_t stage_began_ns_ = 0;
  double wait_s_;
  std::minstd_rand chance_;

  bool accepted_ = false;      ///< heard, not dealt with
  bool birth_wanted_ = false;  ///< likewise
  bool ended_ = false;         ///< likewise
  std::int64_t births_from_ns_ = 0;
  std::string heard_;     ///< why it ended, or what the library said last
  int subscription_ = 0;  ///< the request that is to be answered; 0: none
  std::int64_t answer_by_ns_ = 0;
  bool may_hear_orders_ = true;
  std::uint64_t dropped_said_ = 0;
  bool says_dropping_ = false;
  LogLimit lines_{3, 600.0};
};

}  // namespace spindle_twin::firmware

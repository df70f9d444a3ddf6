#include "firmware/plant/broker_link.hpp"

#include <mosquitto.h>
#include <mqtt_protocol.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <new>
#include <utility>

#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr double first_wait_s = 1.0, longest_wait_s = 30.0;
constexpr double patience_s = 30.0;       // for a connection to stand, and for an answer
constexpr double proven_s = 10.0;         // a connection that held so long is worth trying again soon
constexpr double between_births_s = 1.0;  // whoever asks for them, and how often
constexpr double longest_step_s = 0.5;
constexpr int keep_alive_s = 30;
constexpr std::size_t longest_order = 65536;  // bytes

std::int64_t ns(double seconds) { return static_cast<std::int64_t>(1e9 * seconds); }

/// A key with a passphrase is refused: there is nobody who could be asked.
int no_broker_passphrase(char*, int, int, void*) { return 0; }

BrokerLink& link(void* to) { return *static_cast<BrokerLink*>(to); }

}  // namespace

/// libmosquitto wants to be told when the program begins and ends with it.
struct BrokerLink::Library {
  Library() { mosquitto_lib_init(); }
  ~Library() { mosquitto_lib_cleanup(); }
  static void begin() { static const Library library; }
};

void BrokerLink::End::operator()(mosquitto* session) const { mosquitto_destroy(session); }

BrokerLink::BrokerLink(const PlantPlan& plan, EdgeNode& node, PlantCounts& counts)
    : plan_(plan),
      node_(node),
      counts_(counts),
      wait_s_(first_wait_s),
      chance_(static_cast<std::minstd_rand::result_type>(std::hash<std::string>()(node.order_topic()))) {
  Library::begin();
}

BrokerLink::~BrokerLink() = default;

std::string BrokerLink::reason(int error) const {
  if (error == MOSQ_ERR_ERRNO) return std::strerror(errno);
  std::string why = mosquitto_strerror(error);
  if ((error == MOSQ_ERR_TLS || error == MOSQ_ERR_TLS_HANDSHAKE) && !heard_.empty()) why += " (" + heard_ + ")";
  return why;
}

bool BrokerLink::prepare(const PlantTime& now) {
  const std::string client = plan_.group + "-" + plan_.node;
  session_.reset(mosquitto_new(client.c_str(), true, this));
  if (!session_) throw std::bad_alloc();
  mosquitto* const session = session_.get();
  mosquitto_int_option(session, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5);
  mosquitto_int_option(session, MOSQ_OPT_TCP_NODELAY, 1);
  mosquitto_connect_v5_callback_set(
      session, [](mosquitto*, void* to, int code, int, const mosquitto_property*) { link(to).heard_connected(code); });
  mosquitto_disconnect_v5_callback_set(
      session, [](mosquitto*, void* to, int code, const mosquitto_property*) { link(to).heard_disconnected(code); });
  mosquitto_message_callback_set(session, [](mosquitto*, void* to, const mosquitto_message* message) {
    link(to).heard_message(message->payload, message->payloadlen);
  });
  mosquitto_subscribe_callback_set(session, [](mosquitto*, void* to, int id, int count, const int* granted) {
    link(to).heard_subscribed(id, count > 0 ? granted[0] : MQTT_RC_UNSPECIFIED);
  });
  mosquitto_log_callback_set(session, [](mosquitto*, void* to, int level, const char* text) {
    if (level == MOSQ_LOG_ERR) link(to).heard_ = text;
  });
  const PlantMessage will = node_.will(now.ms);
  int error = mosquitto_will_set(session, will.topic.c_str(), static_cast<int>(will.payload.size()),
                                 will.payload.data(), 1, false);
  if (error == MOSQ_ERR_SUCCESS && plan_.tls) {
    error = mosquitto_tls_set(session, plan_.tls->ca.c_str(), nullptr, plan_.tls->certificate.c_str(),
                              plan_.tls->key.c_str(), no_broker_passphrase);
  }
  if (error == MOSQ_ERR_SUCCESS) return true;
  lose(now, reason(error));
  return false;
}

void BrokerLink::connect(const PlantTime& now) {
  accepted_ = birth_wanted_ = ended_ = false;
  heard_.clear();
  subscription_ = 0;
  if (!prepare(now)) return;
  const int error = mosquitto_connect_async(session_.get(), plan_.host.c_str(), plan_.port, keep_alive_s);
  if (error != MOSQ_ERR_SUCCESS) return lose(now, reason(error));
  stage_ = Stage::connecting;
  stage_began_ns_ = now.ns;
}

pollfd BrokerLink::waits_for() const {
  if (!session_) return {-1, 0, 0};
  const short events = mosquitto_want_write(session_.get()) ? POLLIN | POLLOUT : POLLIN;
  return {mosquitto_socket(session_.get()), events, 0};
}

void BrokerLink::step(const PlantTime& now) {
  if (stage_ == Stage::away) {
    if (now.ns >= due_ns_) connect(now);
  } else {
    read_and_write(now);
  }
  if (stage_ != Stage::away) due_ns_ = now.ns + ns(longest_step_s);
  count();
}

void BrokerLink::read_and_write(const PlantTime& now) {
  mosquitto* const session = session_.get();
  int error = mosquitto_loop_read(session, 1);
  if (error == MOSQ_ERR_SUCCESS && mosquitto_want_write(session)) error = mosquitto_loop_write(session, 1);
  if (error == MOSQ_ERR_SUCCESS) error = mosquitto_loop_misc(session);
  if (error != MOSQ_ERR_SUCCESS || ended_) {
    return lose(now, ended_ && !heard_.empty() ? heard_ : reason(error));
  }
  if (std::exchange(accepted_, false)) greet(now);
  if (stage_ == Stage::connecting && now.ns - stage_began_ns_ > ns(patience_s)) return lose(now, "no answer");
  if (stage_ == Stage::connected) send(now);
}

void BrokerLink::greet(const PlantTime& now) {
  stage_ = Stage::connected;
  stage_began_ns_ = now.ns;
  if (const auto held_back = lines_.pass(now.ns)) {
    spdlog::info("plant: connected to {}:{}{}", plan_.host, plan_.port, LogLimit::also(*held_back));
  }
  renew_subscription(now);
  birth_wanted_ = true;
  births_from_ns_ = now.ns;
}

void BrokerLink::send(const PlantTime& now) {
  if (subscription_ != 0 && now.ns > answer_by_ns_) return lose(now, "the broker does not answer");
  bool fine = true;
  if (birth_wanted_ && now.ns >= births_from_ns_) {
    birth_wanted_ = false;
    births_from_ns_ = now.ns + ns(between_births_s);
    fine = publish(node_.births(now.ms));
  }
  if (subscription_ == 0 && fine) {
    const std::vector<PlantMessage> data = node_.data(now.ms);
    fine = publish(data);
    if (fine && !data.empty()) renew_subscription(now);
  }
  fine = fine && publish(node_.deaths(now.ms));
  if (!fine) lose(now, heard_);
}

bool BrokerLink::publish(const std::vector<PlantMessage>& messages) {
  return std::all_of(messages.begin(), messages.end(), [&](const PlantMessage& message) {
    const int error = mosquitto_publish(session_.get(), nullptr, message.topic.c_str(),
                                        static_cast<int>(message.payload.size()), message.payload.data(), 0, false);
    if (error != MOSQ_ERR_SUCCESS) heard_ = reason(error);
    return error == MOSQ_ERR_SUCCESS;
  });
}

void BrokerLink::renew_subscription(const PlantTime& now) {
  answer_by_ns_ = now.ns + ns(patience_s);
  const int error = mosquitto_subscribe(session_.get(), &subscription_, node_.order_topic().c_str(), 1);
  if (error != MOSQ_ERR_SUCCESS) lose(now, reason(error));
}

/// What the broker had not confirmed is sent again.
void BrokerLink::lose(const PlantTime& now, const std::string& why) {
  const bool was_connected = stage_ == Stage::connected;
  if (was_connected && now.ns - stage_began_ns_ > ns(proven_s)) wait_s_ = first_wait_s;
  const std::string what = fmt::format("{} {}:{}: {}", was_connected ? "connection lost to" : "no connection to",
                                       plan_.host, plan_.port, why);
  stage_ = Stage::away;
  session_.reset();
  node_.disconnected();
  due_ns_ = now.ns + ns(wait_s_ * std::uniform_real_distribution<double>(0.5, 1.0)(chance_));
  const bool is_news = was_connected || wait_s_ == first_wait_s;
  wait_s_ = std::min(2.0 * wait_s_, longest_wait_s);
  if (!is_news) return;
  if (const auto held_back = lines_.pass(now.ns)) {
    spdlog::warn("plant: {}; tried again, samples wait{}", what, LogLimit::also(*held_back));
  }
}

/// Dropped ones are said when it begins, and how many they were when all that waited has gone.
void BrokerLink::count() {
  const std::uint64_t dropped = node_.queue().dropped(), news = dropped - dropped_said_;
  if (news > 0 && !std::exchange(says_dropping_, true)) {
    spdlog::warn("plant: the queue is full, the oldest samples are dropped");
  }
  counts_.dropped = dropped;
  counts_.waiting = node_.queue().waiting() + node_.queue().under_way();
  counts_.connected = connected() ? 1 : 0;
  if (!says_dropping_ || counts_.waiting > 0) return;
  spdlog::warn("plant: {} samples were dropped in all", news);
  dropped_said_ = dropped;
  says_dropping_ = false;
}

void BrokerLink::leave() {
  if (stage_ == Stage::connected) {
    mosquitto_disconnect_v5(session_.get(), MQTT_RC_DISCONNECT_WITH_WILL_MSG, nullptr);
    MonotonicClock clock;
    const std::int64_t end_ns = clock.now_ns() + ns_per_s;
    while (mosquitto_want_write(session_.get()) && clock.now_ns() < end_ns) {
      pollfd writable{mosquitto_socket(session_.get()), POLLOUT, 0};
      constexpr int wait_ms = 100;
      poll(&writable, 1, wait_ms);
      if (mosquitto_loop_write(session_.get(), 1) != MOSQ_ERR_SUCCESS) break;
    }
  }
  stage_ = Stage::away;
  session_.reset();
  counts_.connected = 0;
}

void BrokerLink::heard_connected(int code) {
  accepted_ = code == 0;
  if (code == 0) return;
  ended_ = true;
  heard_ = std::string("refused: ") + mosquitto_reason_string(code);
}

void BrokerLink::heard_disconnected(int code) {
  ended_ = true;
  if (code >= MQTT_RC_UNSPECIFIED) heard_ = std::string("ended by the broker: ") + mosquitto_reason_string(code);
}

void BrokerLink::heard_message(const void* payload, int size) {
  const auto bytes = static_cast<std::size_t>(std::max(0, size));
  if (bytes > longest_order) return;
  birth_wanted_ = birth_wanted_ || node_.asks_for_birth({static_cast<const std::uint8_t*>(payload), bytes});
}

void BrokerLink::heard_subscribed(int id, int granted) {
  if (id != subscription_) return;
  subscription_ = 0;
  counts_.published += node_.confirm();
  const bool may_hear = granted < MQTT_RC_UNSPECIFIED;
  if (std::exchange(may_hear_orders_, may_hear) && !may_hear) {
    spdlog::warn("plant: the broker refuses {}: nobody can ask for births ({})", node_.order_topic(),
                 mosquitto_reason_string(granted));
  }
}

}  // namespace spindle_twin::firmware

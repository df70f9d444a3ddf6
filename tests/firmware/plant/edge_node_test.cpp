#include "firmware/plant/edge_node.hpp"

#include <gtest/gtest.h>
#include <pb_decode.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "firmware/cycle/publish.hpp"
#include "firmware/plant/sparkplug_b.pb.h"
#include "firmware/serve/fill_image.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace plant_edge_node_test {

/// What of a message the tests look at.
struct Seen {
  std::string topic;
  bool has_seq = false;
  std::uint64_t seq = 0;
  std::vector<spindle_twin_plant_Metric> metrics = {};
  std::vector<std::string> names = {};
  std::vector<std::optional<std::uint32_t>> qualities = {};
};

bool take_quality(pb_istream_t* stream, const pb_field_t*, void** arg) {
  spindle_twin_plant_PropertyValue value = spindle_twin_plant_PropertyValue_init_zero;
  if (!pb_decode(stream, spindle_twin_plant_PropertyValue_fields, &value)) return false;
  if (value.has_int_value) *static_cast<std::optional<std::uint32_t>*>(*arg) = value.int_value;
  return true;
}

bool take_metric(pb_istream_t* stream, const pb_field_t*, void** arg) {
  auto& seen = *static_cast<Seen*>(*arg);
  spindle_twin_plant_Metric metric = spindle_twin_plant_Metric_init_zero;
  std::string name;
  metric.name.funcs.decode = [](pb_istream_t* text, const pb_field_t*, void** to) {
    auto& string = *static_cast<std::string*>(*to);
    string.resize(text->bytes_left);
    return pb_read(text, reinterpret_cast<pb_byte_t*>(string.data()), string.size());
  };
  metric.name.arg = &name;
  std::optional<std::uint32_t> quality;
  metric.properties.values.funcs.decode = take_quality;
  metric.properties.values.arg = &quality;
  if (!pb_decode(stream, spindle_twin_plant_Metric_fields, &metric)) return false;
  seen.metrics.push_back(metric);
  seen.names.push_back(name);
  seen.qualities.push_back(quality);
  return true;
}

Seen look(const PlantMessage& message) {
  Seen seen{message.topic};
  spindle_twin_plant_Payload payload = spindle_twin_plant_Payload_init_zero;
  payload.metrics.funcs.decode = take_metric;
  payload.metrics.arg = &seen;
  pb_istream_t stream = pb_istream_from_buffer(message.payload.data(), message.payload.size());
  EXPECT_TRUE(pb_decode(&stream, spindle_twin_plant_Payload_fields, &payload));
  seen.has_seq = payload.has_seq;
  seen.seq = payload.seq;
  return seen;
}

std::unique_ptr<PlantMetrics> metrics() { return std::make_unique<PlantMetrics>(names_of(tests::small_network())); }

EdgeNode node_of(std::initializer_list<const char*> names, std::size_t queue = 100) {
  std::vector<PlantDevice> devices;
  for (const char* name : names) devices.push_back({name, metrics()});
  return {"group", "node", std::move(devices), queue};
}

Snapshot running() {
  Snapshot snapshot = first_snapshot(tests::small_network());
  snapshot.state = State::running;
  snapshot.nose_m = 5e-6;
  for (std::size_t k = 0; k < snapshot.key_points; ++k) snapshot.predicted_K[k] = 300.15;
  snapshot.measured_K[0] = 301.15;
  snapshot.sensor_quality[0] = SensorQuality::good;
  return snapshot;
}

PlantValues values(const EdgeNode& node, const Snapshot& snapshot = running()) {
  RegisterImage image{};
  fill_image(snapshot, 0, image);
  return node.metrics(0).values(image);
}

std::size_t index_of(const PlantMetrics& all, const std::string& name) {
  for (std::size_t m = 0; m < all.all().size(); ++m) {
    if (all.all()[m].name == name) return m;
  }
  ADD_FAILURE() << "no metric " << name;
  return 0;
}

TEST(EdgeNode, its_death_has_the_number_of_its_birth_and_no_place_in_the_sequence) {
  EdgeNode node = node_of({"a"});
  for (int connection = 0; connection < 300; ++connection) {
    const Seen will = look(node.will(1));
    const Seen birth = look(node.births(2).front());
    EXPECT_EQ(will.topic, "spBv1.0/group/NDEATH/node");
    EXPECT_EQ(birth.topic, "spBv1.0/group/NBIRTH/node");
    EXPECT_FALSE(will.has_seq);
    EXPECT_TRUE(birth.has_seq);
    EXPECT_EQ(birth.seq, 0U);
    ASSERT_EQ(will.names.front(), "bdSeq");
    ASSERT_EQ(birth.names.front(), "bdSeq");
    EXPECT_EQ(will.metrics.front().long_value, static_cast<std::uint64_t>(connection % 256));
    EXPECT_EQ(birth.metrics.front().long_value, will.metrics.front().long_value);
  }
}

TEST(EdgeNode, its_messages_are_numbered_from_0_to_255_and_round_again) {
  EdgeNode node = node_of({"a", "b"}, 1000);
  node.will(1);
  std::uint64_t expected = 0;
  for (const PlantMessage& message : node.births(2)) EXPECT_EQ(look(message).seq, expected++ % 256);
  for (std::uint64_t t = 3; t < 800; ++t) {
    node.add(t % 2, t, values(node));
    for (const PlantMessage& message : node.data(t)) EXPECT_EQ(look(message).seq, expected++ % 256);
    node.confirm();
  }
  EXPECT_GT(expected, 512U);
  for (const PlantMessage& message : node.births(900)) {
    const Seen seen = look(message);
    EXPECT_EQ(seen.seq, message.topic == "spBv1.0/group/NBIRTH/node" ? 0U : seen.seq);
  }
}

TEST(EdgeNode, a_device_is_born_before_its_first_data_and_its_aliases_are_its_own) {
  EdgeNode node = node_of({"a", "b"});
  node.will(1);
  EXPECT_EQ(node.births(2).size(), 1U) << "nothing is known of the devices yet";
  node.add(0, 3, values(node));
  node.add(1, 3, values(node));
  const std::vector<PlantMessage> messages = node.data(4);
  ASSERT_EQ(messages.size(), 4U);
  EXPECT_EQ(messages[0].topic, "spBv1.0/group/DBIRTH/node/a");
  EXPECT_EQ(messages[1].topic, "spBv1.0/group/DDATA/node/a");
  EXPECT_EQ(messages[2].topic, "spBv1.0/group/DBIRTH/node/b");
  std::set<std::uint64_t> aliases;
  std::size_t with_alias = 0;
  for (const int birth : {0, 2}) {
    const Seen seen = look(messages[static_cast<std::size_t>(birth)]);
    for (const spindle_twin_plant_Metric& metric : seen.metrics) {
      EXPECT_TRUE(metric.has_datatype);
      EXPECT_TRUE(metric.has_timestamp);
      if (metric.has_alias) aliases.insert(metric.alias), ++with_alias;
    }
  }
  EXPECT_EQ(aliases.size(), with_alias);
  for (const spindle_twin_plant_Metric& metric : look(messages[1]).metrics) {
    EXPECT_TRUE(aliases.contains(metric.alias));
    EXPECT_TRUE(metric.has_datatype);
  }
}

TEST(EdgeNode, a_birth_says_how_good_each_number_is_and_data_of_those_that_were_not_good) {
  EdgeNode node = node_of({"a"});
  node.will(1);
  node.births(2);
  node.add(0, 3, values(node));
  std::vector<PlantMessage> messages = node.data(4);
  ASSERT_EQ(messages.size(), 2U);
  const Seen birth = look(messages[0]), data = look(messages[1]);
  constexpr auto good = static_cast<std::uint32_t>(MetricQuality::good);
  std::map<std::uint64_t, std::uint32_t> at_birth;
  for (std::size_t i = 0; i < birth.metrics.size(); ++i) {
    if (birth.qualities[i]) at_birth[birth.metrics[i].alias] = *birth.qualities[i];
  }
  std::size_t fine = 0, poor = 0;
  for (std::size_t i = 0; i < data.metrics.size(); ++i) {
    ASSERT_TRUE(at_birth.contains(data.metrics[i].alias));
    const std::uint32_t quality = at_birth[data.metrics[i].alias];
    (quality == good ? fine : poor) += 1;
    EXPECT_EQ(data.qualities[i], quality == good ? std::nullopt : std::optional(quality));
  }
  EXPECT_GT(fine, 0U);
  EXPECT_GT(poor, 0U);
}

TEST(EdgeNode, what_nobody_confirmed_is_said_again_as_history_and_nothing_before_it_is_answered) {
  EdgeNode node = node_of({"a"});
  node.will(1);
  node.births(2);
  node.add(0, 3, values(node));
  EXPECT_EQ(node.data(4).size(), 2U);
  node.add(0, 5, values(node));
  EXPECT_TRUE(node.data(6).empty()) << "the one before is under way";
  node.disconnected();
  node.will(7);
  EXPECT_EQ(node.births(8).size(), 2U);
  node.add(0, 9, values(node));
  const std::vector<PlantMessage> again = node.data(10);
  ASSERT_EQ(again.size(), 3U);
  EXPECT_TRUE(look(again[0]).metrics[0].is_historical);
  EXPECT_EQ(look(again[0]).metrics[0].timestamp, 3U);
  EXPECT_TRUE(look(again[1]).metrics[0].is_historical);
  EXPECT_FALSE(look(again[2]).metrics[0].is_historical);
  EXPECT_EQ(node.confirm(), 3U);
}

TEST(EdgeNode, beyond_its_queue_the_oldest_go_and_are_counted) {
  EdgeNode node = node_of({"a", "b"}, 3);
  for (std::uint64_t t = 1; t <= 10; ++t) node.add(t % 2, t, values(node));
  EXPECT_EQ(node.queue().waiting(), 6U);
  EXPECT_EQ(node.queue().dropped(), 4U);
  node.will(20);
  node.births(21);
  const Seen oldest = look(node.data(22).front());
  EXPECT_EQ(oldest.metrics[0].timestamp, 5U);
  for (std::uint64_t t = 30; t < 36; ++t) node.add(t % 2, t, values(node));
  EXPECT_EQ(node.queue().dropped(), 4U) << "six are under way, six wait";
  node.disconnected();
  EXPECT_EQ(node.queue().waiting(), 6U);
  EXPECT_EQ(node.queue().dropped(), 10U);
}

TEST(EdgeNode, a_device_that_stops_dies_once_and_is_born_again) {
  EdgeNode node = node_of({"a"});
  node.will(1);
  node.births(2);
  node.add(0, 3, values(node));
  node.data(4);
  node.stop(0);
  EXPECT_TRUE(node.deaths(5).empty()) << "what it said comes first";
  node.confirm();
  ASSERT_EQ(node.deaths(6).size(), 1U);
  EXPECT_TRUE(node.deaths(7).empty());
  EXPECT_EQ(node.births(8).size(), 1U);
  node.add(0, 9, values(node));
  const std::vector<PlantMessage> again = node.data(10);
  ASSERT_EQ(again.size(), 2U);
  EXPECT_EQ(again[0].topic, "spBv1.0/group/DBIRTH/node/a");
}

TEST(EdgeNode, nobody_dies_while_something_of_it_waits_behind_what_is_under_way) {
  EdgeNode node = node_of({"a"});
  node.will(1);
  node.births(2);
  node.add(0, 3, values(node));
  node.data(4);
  node.add(0, 5, values(node));
  node.stop(0);
  EXPECT_TRUE(node.deaths(6).empty());
  node.confirm();
  EXPECT_TRUE(node.deaths(7).empty());
  EXPECT_EQ(node.data(8).size(), 1U);
  node.confirm();
  EXPECT_EQ(node.deaths(9).size(), 1U);
}

TEST(EdgeNode, sixty_four_samples_are_under_way_at_most_and_the_others_wait) {
  EdgeNode node = node_of({"a"}, 100);
  node.will(1);
  node.births(2);
  for (std::uint64_t t = 3; t < 73; ++t) node.add(0, t, values(node));
  EXPECT_EQ(node.data(80).size(), 1U + 64U) << "with the birth";
  EXPECT_EQ(node.confirm(), 64U);
  EXPECT_EQ(node.data(81).size(), 6U);
}

TEST(EdgeNode, what_was_measured_before_its_birth_is_history_and_what_at_that_moment_is_not) {
  EdgeNode node = node_of({"a"});
  node.will(1);
  node.births(100);
  node.add(0, 99, values(node));
  node.add(0, 100, values(node));
  const std::vector<PlantMessage> messages = node.data(101);
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_FALSE(look(messages[0]).metrics[1].is_historical) << "a birth is of now";
  EXPECT_TRUE(look(messages[1]).metrics[0].is_historical);
  EXPECT_FALSE(look(messages[2]).metrics[0].is_historical);
}

TEST(EdgeNode, metrics_of_all_devices_are_numbered_from_1_on_and_it_wants_no_rebirth_itself) {
  EdgeNode node = node_of({"a", "b"});
  node.will(1);
  const Seen birth = look(node.births(2).front());
  ASSERT_EQ(birth.names.size(), 3U);
  EXPECT_EQ(birth.names[1], "Node Control/Rebirth");
  EXPECT_TRUE(birth.metrics[1].has_boolean_value);
  EXPECT_FALSE(birth.metrics[1].boolean_value);
  for (const std::size_t device : {0U, 1U}) node.add(device, 3, values(node));
  const std::vector<PlantMessage> messages = node.data(4);
  ASSERT_EQ(messages.size(), 4U);
  std::uint64_t alias = 0;
  for (const std::size_t data : {1U, 3U}) {
    for (const spindle_twin_plant_Metric& metric : look(messages[data]).metrics) EXPECT_EQ(metric.alias, ++alias);
  }
}

TEST(PlantMetrics, are_what_metrics_show_under_names_that_stand_once) {
  const PlantMetrics all(names_of(tests::small_network()));
  std::set<std::string> names;
  for (const PlantMetric& metric : all.all()) EXPECT_TRUE(names.insert(metric.name).second) << metric.name;
  for (const char* name : {"nose", "state", "fault/orders_lost", "compensation", "overruns", "device_accepted/0"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
  EXPECT_TRUE(names.contains("key_point_predicted/" + tests::small_network().key_points[0].name));
}

TEST(PlantMetrics, are_of_the_registers_that_were_asked_for) {
  const PlantMetrics all(names_of(tests::small_network()), {"nose", "state"});
  ASSERT_EQ(all.all().size(), 2U);
  EXPECT_EQ(all.all()[0].name, "state");
  EXPECT_TRUE(is_published("nose"));
  EXPECT_FALSE(is_published("nose_float32"));
}

TEST(PlantMetrics, counts_and_codes_stay_whole_and_what_has_steps_or_fractions_is_a_float) {
  const PlantMetrics all(names_of(tests::small_network()));
  std::set<DataType> met;
  for (const PlantMetric& metric : all.all()) {
    const RegisterEntry& entry = entry_of(metric.shown.which);
    const bool real = entry.type == RegisterType::float32 || entry.type == RegisterType::float32_cdab;
    const bool whole = entry.resolution == 1.0 && !real;
    met.insert(metric.type);
    EXPECT_EQ(metric.type == DataType::boolean, metric.shown.bit != nullptr) << metric.name;
    EXPECT_EQ(metric.type == DataType::float32, !whole && metric.shown.bit == nullptr) << metric.name;
    if (entry.type == RegisterType::uint32 && whole && metric.shown.bit == nullptr) {
      EXPECT_EQ(metric.type, DataType::int64) << metric.name << ": some libraries have no UInt32";
    }
  }
  EXPECT_GE(met.size(), 4U);
}

TEST(PlantMetrics, tell_how_good_a_number_is) {
  const std::string key_point = tests::small_network().key_points[0].name;
  const PlantMetrics all(names_of(tests::small_network()));
  const auto quality = [&](const Snapshot& snapshot, const std::string& name) {
    RegisterImage image{};
    fill_image(snapshot, 0, image);
    return all.values(image).qualities[index_of(all, name)];
  };
  Snapshot snapshot = running();
  EXPECT_EQ(quality(snapshot, "nose"), MetricQuality::good);
  EXPECT_EQ(quality(snapshot, "key_point_measured/" + key_point), MetricQuality::good);
  EXPECT_EQ(quality(snapshot, "motor_current"), MetricQuality::bad) << "not present";
  snapshot.sensor_quality[0] = SensorQuality::stale;
  EXPECT_EQ(quality(snapshot, "key_point_measured/" + key_point), MetricQuality::stale);
  snapshot.sensor_quality[0] = SensorQuality::out_of_range;
  EXPECT_EQ(quality(snapshot, "key_point_measured/" + key_point), MetricQuality::bad);
  snapshot.state = State::fault;
  EXPECT_EQ(quality(snapshot, "nose"), MetricQuality::bad);
  EXPECT_EQ(quality(snapshot, "state"), MetricQuality::good) << "the state itself is known";
}

}  // namespace plant_edge_node_test
}  // namespace spindle_twin::firmware

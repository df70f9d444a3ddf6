#include "firmware/acquire/stream_device.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <memory>

#include "tests/firmware/acquire/stream_frames.hpp"
#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/no_descriptors.hpp"

namespace spindle_twin::firmware {
namespace acquire_stream_device_test {

constexpr double second_ns = 1e9;

/// A stream device with its readings, stepped by hand at times that the test says; sockets are real.
class SteppedClock final : public Clock {
 public:
  std::int64_t now_ns() const override { return time_ns; }
  void sleep_until_ns(std::int64_t until_ns) override { time_ns = std::max(time_ns, until_ns); }
  std::int64_t time_ns = static_cast<std::int64_t>(100 * second_ns);
};

class StreamDeviceTest : public testing::Test {
 protected:
  StreamDeviceTest() {
    plan_.allow = {*parse_address_range("127.0.0.1")};
    plan_.connections = 2;
    plan_.numbers = {0, 1, 10};
    device_ = std::make_unique<StreamDevice>(plan_, clock_);
    step(1);
  }
  ~StreamDeviceTest() override {
    for (const int socket : sockets_) close(socket);
  }

  int open_socket(const char* address) {
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in here{};
    here.sin_family = AF_INET;
    inet_pton(AF_INET, address, &here.sin_addr);
    EXPECT_EQ(bind(socket, reinterpret_cast<const sockaddr*>(&here), sizeof here), 0);
    sockets_.push_back(socket);
    return socket;
  }
  void connect_to_device(int socket) {
    sockaddr_in there{};
    there.sin_family = AF_INET;
    there.sin_port = htons(static_cast<std::uint16_t>(device_->port()));
    inet_pton(AF_INET, "127.0.0.1", &there.sin_addr);
    EXPECT_EQ(connect(socket, reinterpret_cast<const sockaddr*>(&there), sizeof there), 0);
  }
  int connect_from(const char* address) {
    const int socket = open_socket(address);
    connect_to_device(socket);
    step(2);
    return socket;
  }
  void send_bytes(int socket, const std::vector<std::uint8_t>& bytes) {
    ASSERT_EQ(send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
    step(2);
  }
  Step step(int times = 1) {
    Step last;
    for (int i = 0; i < times; ++i) last = device_->step(readings_);
    return last;
  }
  void pass(double time_s) { clock_.time_ns += static_cast<std::int64_t>(time_s * second_ns); }
  const Reading& sensor(std::size_t k) const { return readings_.frame().sensors[k]; }
  std::uint32_t accepted() const { return readings_.frame().devices[1].accepted; }
  std::uint32_t refused() const { return readings_.frame().devices[1].refused; }

  SteppedClock clock_;
  StreamPlan plan_;
  DeviceReadings readings_{"node",
                           1,
                           {{Channel::Kind::sensor, 0, "a", {}, {}},
                            {Channel::Kind::sensor, 3, "b", {}, {}},
                            {Channel::Kind::signal, 1, "fast", {}, {FilterPlan::Kind::mean, 0.1}}},
                           0.25};
  std::unique_ptr<StreamDevice> device_;
  std::vector<int> sockets_;
};

TEST_F(StreamDeviceTest, values_go_to_their_channels_with_the_age_of_clock_transmission_and_delay) {
  EXPECT_EQ(step().is, Step::Is::waiting);
  const int socket = connect_from("127.0.0.1");
  node sender{};
  node_add(&sender, 0, 28.5F, 40);
  node_add(&sender, 1, 17.0F, 0);
  node_add(&sender, 999, 1.0F, 0);  // of no channel
  send_bytes(socket, frames::frame_of(sender, 5000, {}));
  EXPECT_EQ(step().is, Step::Is::fresh);
  EXPECT_EQ(sensor(0).value, 28.5);
  EXPECT_EQ(sensor(0).time_ns, static_cast<std::int64_t>(99.71 * second_ns));
  EXPECT_EQ(sensor(3).value, 17.0);
  EXPECT_EQ(sensor(3).time_ns, static_cast<std::int64_t>(99.75 * second_ns));
  pass(3.0);  // the next frame is held up for two seconds
  send_bytes(socket, frames::frame_of(sender, 6000, {29.0F}));
  EXPECT_EQ(sensor(0).value, 29.0);
  EXPECT_EQ(sensor(0).time_ns, static_cast<std::int64_t>(100.75 * second_ns));
  EXPECT_EQ(accepted(), 2U);
  EXPECT_EQ(refused(), 0U);
}

TEST_F(StreamDeviceTest, of_frames_that_come_together_the_last_one_counts_and_none_overtakes_by_more_than_a_second) {
  const int socket = connect_from("127.0.0.1");
  node sender{};
  auto both = frames::frame_of(sender, 0, {20.0F});
  const auto second = frames::frame_of(sender, 500, {21.0F});
  both.insert(both.end(), second.begin(), second.end());
  send_bytes(socket, both);
  EXPECT_EQ(sensor(0).value, 21.0);
  node_add(&sender, 0, 19.0F, 3000);
  send_bytes(socket, frames::frame_of(sender, 600, {}));
  EXPECT_EQ(sensor(0).value, 21.0) << "measured before";
}

TEST_F(StreamDeviceTest, a_burst_at_1_kHz_becomes_its_mean) {
  const int socket = connect_from("127.0.0.1");
  node sender{};
  for (int frames = 0; frames < 3; ++frames) {
    for (int i = 0; i < 100; ++i) node_add_fast(&sender, 10, i % 2 == 0 ? 0.5F : 1.5F, 1000);
    send_bytes(socket, frames::frame_of(sender, static_cast<std::uint32_t>(100 * frames), {}));
    pass(0.1);
  }
  EXPECT_DOUBLE_EQ(readings_.frame().signals[1].value, 1.0);
  // The second frame's last value is of 100.1 s, its middle 49.5 ms older, all 0.25 s late.
  EXPECT_NEAR(static_cast<double>(readings_.frame().signals[1].time_ns), 99.8005 * second_ns, 1e3);
}

TEST_F(StreamDeviceTest, a_frame_has_its_second_from_its_first_byte_on_and_no_nanosecond_more) {
  const int socket = connect_from("127.0.0.1");
  node sender{};
  send_bytes(socket, frames::frame_of(sender, 0, {20.0F}));
  pass(5.0);
  for (const bool in_time : {true, false}) {
    const auto frame = frames::frame_of(sender, 5000, {in_time ? 21.0F : 22.0F});
    send_bytes(socket, {frame.begin(), frame.begin() + 9});
    clock_.time_ns += static_cast<std::int64_t>(second_ns) + (in_time ? 0 : 1);
    step();
    EXPECT_EQ(refused(), in_time ? 0U : 1U);
    send_bytes(socket, {frame.begin() + 9, frame.end()});
    EXPECT_EQ(sensor(0).value, 21.0);
  }
}

/// A length that lies: the frame behind it stands within what it claims.
TEST_F(StreamDeviceTest, what_stands_behind_a_frame_that_never_became_whole_is_taken_in_the_end) {
  node sender{};
  float value = 20.0F;
  for (const bool closes : {true, false}) {
    const int socket = connect_from("127.0.0.1");
    auto bytes = frames::frame_of(sender, 0, {1.0F});
    bytes[4] = 7;  // 1792 bytes more than there are
    const auto behind = frames::frame_of(sender, 0, {++value});
    bytes.insert(bytes.end(), behind.begin(), behind.end());
    send_bytes(socket, bytes);
    EXPECT_NE(sensor(0).value, static_cast<double>(value));
    if (closes) {
      shutdown(socket, SHUT_RDWR);
    } else {
      pass(1.001);
    }
    step(2);
    EXPECT_EQ(sensor(0).value, static_cast<double>(value)) << closes;
    EXPECT_EQ(refused(), closes ? 1U : 2U);
  }
}

TEST_F(StreamDeviceTest, a_node_is_there_from_its_first_frame_on_and_for_ten_seconds_behind_each) {
  const int socket = connect_from("127.0.0.1");
  EXPECT_EQ(step().is, Step::Is::waiting) << "it has said nothing";
  node sender{};
  send_bytes(socket, frames::frame_of(sender, 0, {20.0F}));
  clock_.time_ns += static_cast<std::int64_t>(10 * second_ns);
  EXPECT_EQ(step().is, Step::Is::fresh);
  clock_.time_ns += 1;
  const Step ended = step();
  EXPECT_EQ(ended.is, Step::Is::waiting);
  EXPECT_EQ(ended.reason, "the node sent no frame in time");
}

TEST_F(StreamDeviceTest, flipped_cut_and_doubled_frames_are_refused_counted_and_change_nothing) {
  const int socket = connect_from("127.0.0.1");
  node sender{};
  send_bytes(socket, frames::frame_of(sender, 0, {20.0F}));
  auto flipped = frames::frame_of(sender, 10, {99.0F});
  flipped[14] ^= 0x10;
  send_bytes(socket, flipped);
  EXPECT_EQ(refused(), 1U);
  const auto good = frames::frame_of(sender, 20, {21.0F});
  send_bytes(socket, good);
  send_bytes(socket, good);
  EXPECT_EQ(refused(), 2U);
  auto cut = frames::frame_of(sender, 30, {99.0F});
  cut.resize(cut.size() - 3);
  send_bytes(socket, cut);
  EXPECT_EQ(sensor(0).value, 21.0);
  pass(0.5);
  EXPECT_EQ(refused(), 2U) << "its rest may come";
  pass(1.0);
  step();
  EXPECT_EQ(refused(), 3U) << "a frame must be whole a second after it began";
  send_bytes(socket, frames::frame_of(sender, 1600, {22.0F}));
  EXPECT_EQ(sensor(0).value, 22.0);
  EXPECT_EQ(accepted(), 3U);
}

TEST_F(StreamDeviceTest, a_silent_node_is_closed_and_may_come_back) {
  int socket = connect_from("127.0.0.1");
  node sender{};
  send_bytes(socket, frames::frame_of(sender, 0, {20.0F}));
  EXPECT_EQ(step().is, Step::Is::fresh);
  pass(10.5);
  EXPECT_EQ(step().is, Step::Is::waiting);
  char byte = 0;
  EXPECT_EQ(recv(socket, &byte, 1, 0), 0) << "closed";
  EXPECT_EQ(sensor(0).value, 20.0) << "the last reading stays and grows old";
  socket = connect_from("127.0.0.1");
  node_start(&sender);
  send_bytes(socket, frames::frame_of(sender, 0, {23.0F}));
  EXPECT_EQ(sensor(0).value, 23.0) << "a sequence belongs to its connection";
}

TEST_F(StreamDeviceTest, a_node_that_closes_is_gone_at_once_with_the_reason) {
  const int socket = connect_from("127.0.0.1");
  node sender{};
  send_bytes(socket, frames::frame_of(sender, 0, {20.0F}));
  EXPECT_EQ(step().is, Step::Is::fresh);
  shutdown(socket, SHUT_RDWR);
  const Step last = step(2);
  EXPECT_EQ(last.is, Step::Is::waiting);
  EXPECT_EQ(last.reason, "the node closed the connection");
  EXPECT_EQ(sensor(0).value, 20.0) << "the last reading stays and grows old";
}

TEST_F(StreamDeviceTest, strangers_are_closed_and_the_longest_silent_of_too_many_makes_room) {
  const int stranger = connect_from("127.0.0.3");
  char byte = 0;
  EXPECT_EQ(recv(stranger, &byte, 1, 0), 0);
  const int silent = connect_from("127.0.0.1");
  pass(1.0);
  const int speaking = connect_from("127.0.0.1");
  node sender{};
  pass(1.0);
  connect_from("127.0.0.1");
  EXPECT_EQ(recv(silent, &byte, 1, 0), 0);
  send_bytes(speaking, frames::frame_of(sender, 0, {24.0F}));
  EXPECT_EQ(sensor(0).value, 24.0);
}

TEST_F(StreamDeviceTest, a_node_that_floods_noise_is_only_counted) {
  const int socket = connect_from("127.0.0.1");
  for (int i = 0; i < 50; ++i) send_bytes(socket, std::vector<std::uint8_t>(20000, 'S'));
  EXPECT_GE(refused(), 1U);
  node sender{};
  send_bytes(socket, frames::frame_of(sender, 0, {25.0F}));
  EXPECT_EQ(sensor(0).value, 25.0);
}

/// Another node waits in the backlog all the time, so that poll() returns at once.
TEST_F(StreamDeviceTest, without_descriptors_it_says_so_serves_its_nodes_and_takes_others_later) {
  const int first = connect_from("127.0.0.1");
  node sender{};
  send_bytes(first, frames::frame_of(sender, 0, {20.0F}));
  const Logged logged;
  const int second = open_socket("127.0.0.1");
  const std::int64_t before_ns = clock_.time_ns;
  {
    const NoDescriptors none;
    connect_to_device(second);
    step(20);
    EXPECT_GE(clock_.time_ns - before_ns, static_cast<std::int64_t>(1.9 * second_ns)) << "it spins";
    send_bytes(first, frames::frame_of(sender, 2000, {21.0F}));
    EXPECT_EQ(sensor(0).value, 21.0);
  }
  const std::string text = logged.text();
  EXPECT_EQ(text.substr(0, text.find('\n')), "error no node can be accepted at 127.0.0.1:0: Too many open files");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3) << "three lines a minute";
  step(2);
  node other{};
  send_bytes(second, frames::frame_of(other, 0, {22.0F}));
  EXPECT_EQ(sensor(0).value, 22.0);
}

/// poll() refuses more sockets than descriptors are allowed.
TEST_F(StreamDeviceTest, behind_a_poll_that_fails_it_waits_says_so_and_takes_what_has_come) {
  const int socket = connect_from("127.0.0.1");
  node sender{};
  send_bytes(socket, frames::frame_of(sender, 0, {20.0F}));
  const Logged logged;
  const std::int64_t before_ns = clock_.time_ns;
  {
    rlimit before{};
    ::getrlimit(RLIMIT_NOFILE, &before);
    const rlimit none{1, before.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &none);
    step(10);
    ::setrlimit(RLIMIT_NOFILE, &before);
  }
  EXPECT_GE(clock_.time_ns - before_ns, static_cast<std::int64_t>(0.9 * second_ns)) << "it spins";
  EXPECT_NE(logged.text().find("error no node can be waited for at 127.0.0.1:0: Invalid argument"), std::string::npos)
      << logged.text();
  send_bytes(socket, frames::frame_of(sender, 1000, {21.0F}));
  EXPECT_EQ(sensor(0).value, 21.0);
}

TEST(StreamDevice, a_port_that_is_taken_is_a_lost_device_with_its_reason) {
  SteppedClock clock;
  StreamPlan plan;
  DeviceReadings readings("node", 0, {}, 0.0);
  StreamDevice first(plan, clock);
  first.step(readings);
  plan.port = first.port();
  StreamDevice second(plan, clock);
  EXPECT_THROW(second.step(readings), rom::InputError);
}

}  // namespace acquire_stream_device_test
}  // namespace spindle_twin::firmware

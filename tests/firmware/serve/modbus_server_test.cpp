#include "firmware/serve/modbus_server.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "rom/read/input_error.hpp"
#include "tests/firmware/support/no_descriptors.hpp"
#include "tests/firmware/support/serving.hpp"

namespace spindle_twin::firmware {
namespace serve_modbus_server_test {

using namespace serving;

TEST(ModbusServer, a_request_sees_the_newest_snapshot) {
  Serving serving;
  Client client(serving.server.port());
  Snapshot snapshot;
  snapshot.sequence = 70001;
  snapshot.nose_m = 12.34e-6;
  serving.snapshots.write(snapshot);
  const Bytes words = payload(client.ask({4, 0, 7, 0, 9}));
  EXPECT_EQ(words[0] << 8 | words[1], 70001 & 0xFFFF);
  EXPECT_EQ(words[16] << 8 | words[17], 123);
}

TEST(ModbusServer, a_request_in_pieces_is_answered_when_whole) {
  Serving serving;
  Client client(serving.server.port());
  for (const std::uint8_t byte : Client::framed(read_known)) {
    client.send({byte});
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(payload(client.receive()), known_words);
}

TEST(ModbusServer, requests_sent_at_once_are_answered_in_order) {
  Serving serving;
  Client client(serving.server.port());
  const Bytes first = Client::framed(read_known);
  const Bytes second = Client::framed({4, 0, 0, 0, 1});
  Bytes both(first.size() + second.size());
  std::copy(second.begin(), second.end(), std::copy(first.begin(), first.end(), both.begin()));
  client.send(both);
  EXPECT_EQ(payload(client.receive()), known_words);
  EXPECT_EQ(payload(client.receive()), (Bytes{0x12, 0x34}));
}

/// poll() refuses more descriptors than a process may have.
TEST(ModbusServer, goes_on_behind_a_poll_that_failed) {
  Serving serving;
  Client client(serving.server.port());
  EXPECT_EQ(payload(client.ask(read_known)), known_words);
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  const rlimit none{2, before.rlim_max};
  ::setrlimit(RLIMIT_NOFILE, &none);
  client.send(Client::framed(read_known));  // the next poll fails, or the one behind this question
  std::this_thread::sleep_for(std::chrono::milliseconds(250));
  ::setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(payload(client.receive()), known_words);
  EXPECT_EQ(payload(client.ask(read_known)), known_words);
}

/// How often it was asked.
class CountingClock final : public Clock {
 public:
  std::int64_t now_ns() const override {
    ++asked;
    return real_.now_ns();
  }
  void sleep_until_ns(std::int64_t until_ns) override { real_.sleep_until_ns(until_ns); }
  mutable std::atomic<int> asked{0};

 private:
  MonotonicClock real_;
};

/// The client waits in the backlog meanwhile, and makes its socket ready at every look.
TEST(ModbusServer, without_descriptors_accepting_pauses_instead_of_spinning) {
  CountingClock clock;
  Serving ports;  // for its snapshots and orders alone
  ModbusServer server(Serving::plan(), clock, {{units_of_one_spindle(), ports.snapshots, ports.signals, ports.orders}});
  std::thread thread([&] { server.run(); });
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(static_cast<std::uint16_t>(server.port()));
  there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const Descriptor client(::socket(AF_INET, SOCK_STREAM, 0));
  {
    const NoDescriptors none;
    ASSERT_EQ(::connect(client.get(), reinterpret_cast<const sockaddr*>(&there), sizeof there), 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    EXPECT_LT(clock.asked, 100);
  }
  server.stop();
  thread.join();
}

TEST(ModbusServer, a_client_that_drips_is_closed_at_the_deadline_and_others_are_served_meanwhile) {
  Serving serving;
  Client good(serving.server.port());
  std::vector<std::unique_ptr<Client>> drippers;
  for (int i = 0; i < 4; ++i) drippers.push_back(std::make_unique<Client>(serving.server.port()));
  const Bytes frame = Client::framed(read_known);
  for (std::size_t n = 0; n < 6; ++n) {
    for (const auto& dripper : drippers) dripper->send({frame[n]});
    EXPECT_EQ(payload(good.ask(read_known)), known_words);
    std::this_thread::sleep_for(std::chrono::milliseconds(80));
  }
  for (const auto& dripper : drippers) EXPECT_TRUE(dripper->closed_by_server());
  EXPECT_EQ(payload(good.ask(read_known)), known_words);
}

TEST(ModbusServer, half_a_frame_then_silence_or_an_end_closes_the_connection) {
  Serving serving;
  Client silent(serving.server.port());
  silent.send({0, 1, 0, 0, 0, 6, 1, 4});
  EXPECT_TRUE(silent.closed_by_server());
}

TEST(ModbusServer, garbage_and_impossible_lengths_close_the_connection) {
  Serving serving;
  for (const Bytes& bytes : {Bytes{'G', 'E', 'T', ' ', '/', ' ', 'H', 'T'}, Bytes{0, 1, 0, 0, 4, 0, 1, 4, 0, 0}}) {
    Client client(serving.server.port());
    client.send(bytes);
    EXPECT_TRUE(client.closed_by_server());
  }
  Client good(serving.server.port());
  EXPECT_EQ(payload(good.ask(read_known)), known_words);
}

TEST(ModbusServer, commands_reach_the_cycle_and_read_back) {
  Serving serving;
  Client client(serving.server.port());
  EXPECT_EQ(client.ask(write_single(Register::command_speed, 6000)).size(), 12U);
  EXPECT_EQ(client.ask({16, 3, 233, 0, 2, 4, 1, 244, 0xFF, 0x38}).size(), 12U);
  EXPECT_EQ(client.ask(write_single(Register::command_tare, 1)).size(), 12U);
  EXPECT_EQ(payload(client.ask({3, 3, 232, 0, 6})),
            (Bytes{0x17, 0x70, 0x01, 0xF4, 0xFF, 0x38, 0x80, 0x00, 0xFF, 0xFF, 0x00, 0x00}));
  PlcSignals told;
  ASSERT_TRUE(serving.signals.read(told));
  EXPECT_EQ(told.values[0].value, 6000.0);
  EXPECT_NEAR(told.values[1].value, 0.5, 1e-12);
  EXPECT_NEAR(told.values[2].value, 273.15 - 2.0, 1e-9);
  EXPECT_EQ(told.values[3].time_ns, 0);
  PlcCommand command;
  serving.orders.hand_out(command);
  EXPECT_EQ(command.tare_orders, 1U);
}

TEST(ModbusServer, who_takes_no_answers_is_ended_before_half_a_megabyte_of_them_waits_in_the_kernel) {
  Serving serving;
  Client deaf(serving.server.port());
  const Bytes request = Client::framed({4, 0, 0, 0, 125});
  for (int n = 0; n < 2000; ++n) deaf.send(request);
  EXPECT_TRUE(deaf.reset_by_server());
  Client good(serving.server.port());
  EXPECT_EQ(payload(good.ask(read_known)), known_words);
}

TEST(ModbusServer, the_client_after_the_last_place_is_turned_away) {
  ServePlan plan = Serving::plan();
  plan.connections = 2;
  Serving serving(plan);
  Client a(serving.server.port());
  Client b(serving.server.port());
  EXPECT_EQ(payload(a.ask(read_known)), known_words);
  EXPECT_EQ(payload(b.ask(read_known)), known_words);
  Client c(serving.server.port());
  EXPECT_TRUE(c.closed_by_server());
  EXPECT_EQ(payload(a.ask(read_known)), known_words);
}

TEST(ModbusServer, a_descriptor_that_libmodbus_cannot_take_is_turned_away) {
  Serving serving;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit enough{2048, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &enough), 0);
  std::vector<int> taken;
  while (taken.empty() || taken.back() < 1023) {
    taken.push_back(open("/dev/null", O_RDONLY));
    ASSERT_GE(taken.back(), 0);
  }
  for (const bool fits : {false, true}) {
    close(taken.back());  // for the client: the server's own is 1024; then the server's is 1023
    taken.pop_back();
    Client client(serving.server.port());
    if (fits) {
      EXPECT_EQ(payload(client.ask(read_known)), known_words);
    } else {
      EXPECT_TRUE(client.closed_by_server());
    }
  }
  for (const int descriptor : taken) close(descriptor);
  setrlimit(RLIMIT_NOFILE, &before);
}

TEST(ModbusServer, orders_that_find_the_queue_full_are_answered_with_busy_and_change_nothing) {
  Serving serving;
  Client client(serving.server.port());
  std::size_t taken = 0;
  Bytes reply;
  while (taken < 100 && exception_of(reply = client.ask(write_single(Register::command_tare, 1))) == 0) ++taken;
  EXPECT_EQ(exception_of(reply), 6);
  EXPECT_GT(taken, 50U);
  EXPECT_LE(taken, OrderDesk::room);
  EXPECT_EQ(exception_of(client.ask(write_single(Register::command_speed, 5))), 0) << "a signal needs no place";
}

TEST(ModbusServer, an_order_from_another_thread_goes_the_way_of_written_ones_and_moves_the_switch_that_is_read_back) {
  Serving serving;
  Client client(serving.server.port());
  EXPECT_TRUE(serving.server.order(0, {OrderKind::tare, 60001, 1, {}}));
  EXPECT_TRUE(serving.server.order(0, {OrderKind::compensation, 60002, 0, {}}));
  const Bytes read_back = payload(client.ask({3, 0x04, 0x05, 0, 1}));
  EXPECT_EQ(read_back, (Bytes{0, 0}));
  PlcCommand command;
  serving.orders.hand_out(command);
  EXPECT_EQ(command.tare_orders, 1U);
  EXPECT_EQ(command.compensation, SwitchOrder::off);
  for (std::size_t n = 0; n < OrderDesk::room; ++n) {
    EXPECT_TRUE(serving.server.order(0, {OrderKind::tare, 60003, 1, {}})) << n;
  }
  EXPECT_FALSE(serving.server.order(0, {OrderKind::tare, 60004, 1, {}}));
}

TEST(ModbusServer, an_order_that_no_server_takes_is_not_obeyed_later) {
  MonotonicClock clock;
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk orders;
  ModbusServer server(Serving::plan(), clock, {{units_of_one_spindle(), snapshots, signals, orders}});
  EXPECT_FALSE(server.order(0, {OrderKind::tare, 60001, 1, {}}));
  std::thread runs([&] { server.run(); });
  server.stop();
  runs.join();
  EXPECT_TRUE(orders.has_room_for(OrderDesk::room));
}

TEST(ModbusServer, a_connection_that_asks_nothing_is_closed_and_one_that_asks_is_not) {
  ServePlan plan = Serving::plan();
  plan.idle_s = 0.5;
  Serving serving(plan);
  Client idle(serving.server.port());
  Client busy(serving.server.port());
  for (int i = 0; i < 15; ++i) {
    EXPECT_EQ(payload(busy.ask(read_known)), known_words);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_TRUE(idle.closed_by_server());
  EXPECT_EQ(payload(busy.ask(read_known)), known_words);
}

/// A clock that is set by hand.
struct HandClock final : Clock {
  std::atomic<std::int64_t> time_ns{1'000'000'000};
  std::int64_t now_ns() const override { return time_ns; }
  void sleep_until_ns(std::int64_t) override {}
};

TEST(ModbusServer, the_longest_idle_connection_makes_room_and_one_address_has_its_share_only) {
  HandClock clock;
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk orders;
  ServePlan plan = Serving::plan();
  plan.connections_per_host = 2;
  ModbusServer server(plan, clock, {{units_of_one_spindle(), snapshots, signals, orders}});
  std::thread thread([&] { server.run(); });
  Client first(server.port());
  EXPECT_EQ(payload(first.ask(read_known)), known_words);
  clock.time_ns += 1'000'000'000;
  Client second(server.port());
  EXPECT_EQ(payload(second.ask(read_known)), known_words);
  clock.time_ns += 2'000'000'000;
  Client refused(server.port());
  EXPECT_TRUE(refused.closed_by_server()) << "nobody has been idle for long";
  clock.time_ns += 6'000'000'000;
  EXPECT_EQ(payload(first.ask(read_known)), known_words);
  Client third(server.port());
  EXPECT_EQ(payload(third.ask(read_known)), known_words);
  EXPECT_TRUE(second.closed_by_server()) << "the longest idle one";
  EXPECT_EQ(payload(first.ask(read_known)), known_words);
  server.stop();
  thread.join();
}

TEST(ModbusServer, who_told_signals_and_goes_on_talking_is_heard_and_who_wrote_once_is_not_waited_for) {
  Serving serving;
  Client plc(serving.server.port());
  Client reader(serving.server.port());
  // The server has one thread: what it answers after a request, it answers when that is done with.
  const auto finish = [&] { EXPECT_EQ(payload(reader.ask(read_known)), known_words); };
  PlcSignals told;
  plc.ask(write_single(Register::command_speed, 6000));
  finish();
  ASSERT_TRUE(serving.signals.read(told));
  EXPECT_EQ(told.alive_ns[0], 0) << "a tool that writes once";
  for (int i = 0; i < 3; ++i) plc.ask(read_known);
  finish();
  ASSERT_TRUE(serving.signals.read(told));
  const std::int64_t heard_ns = told.alive_ns[0];
  EXPECT_GT(heard_ns, 0);
  for (int i = 0; i < 5; ++i) reader.ask(read_known);
  EXPECT_FALSE(serving.signals.read(told)) << "another one's requests say nothing of the PLC";
  plc.ask(read_known);
  finish();
  ASSERT_TRUE(serving.signals.read(told));
  EXPECT_GT(told.alive_ns[0], heard_ns);
}

TEST(ModbusServer, once_a_plc_is_heard_a_new_connection_counts_by_what_it_tells_and_only_then_by_what_it_asks) {
  Serving serving;
  PlcSignals told;
  Client reader(serving.server.port());
  /// What the cycle is told after the server is done with the request before; 0: nothing new.
  const auto heard_ns = [&] {
    EXPECT_EQ(payload(reader.ask(read_known)), known_words);
    return serving.signals.read(told) ? told.alive_ns[0] : 0;
  };
  Client plc(serving.server.port());
  plc.ask(write_single(Register::command_speed, 6000));
  for (int i = 0; i < 3; ++i) plc.ask(read_known);
  const std::int64_t first_ns = heard_ns();
  ASSERT_GT(first_ns, 0);
  Client again(serving.server.port());
  again.ask(read_known);
  EXPECT_EQ(heard_ns(), 0) << "it has told nothing";
  again.ask(write_single(Register::command_speed, 5000));
  const std::int64_t second_ns = heard_ns();
  EXPECT_GT(second_ns, first_ns) << "the PLC has come back";
  again.ask(read_known);
  EXPECT_EQ(heard_ns(), 0) << "two requests are no cycle yet: a tool reads back what it wrote";
  again.ask(read_known);
  EXPECT_GT(heard_ns(), second_ns);
}

TEST(ModbusServer, a_client_that_is_not_on_the_list_is_turned_away) {
  ServePlan plan = Serving::plan();
  plan.allow = {*parse_address_range("10.0.0.0/8")};
  Serving serving(plan);
  Client client(serving.server.port());
  EXPECT_TRUE(client.closed_by_server());
}

TEST(ModbusServer, who_may_only_read_gets_exception_2_for_each_way_of_writing_and_nothing_is_taken) {
  ServePlan plan = Serving::plan();
  plan.write = {*parse_address_range("127.0.0.2")};
  Serving serving(plan);
  Client client(serving.server.port());
  const Bytes single{6, 3, 232, 0, 1}, several{16, 3, 232, 0, 1, 2, 0, 1}, mask{22, 3, 232, 0, 0, 0, 1};
  const Bytes and_read{23, 0, 0, 0, 1, 3, 232, 0, 1, 2, 0, 1};
  for (const Bytes& write : {single, several, mask, and_read}) {
    const Bytes answer = client.ask(write);
    ASSERT_EQ(answer.size(), 9U) << int{write[0]};
    EXPECT_EQ(answer[7], write[0] | 0x80);
    EXPECT_EQ(answer[8], 2);
  }
  PlcSignals told;
  serving.signals.read(told);
  EXPECT_EQ(told.alive_ns[0], 0);
  EXPECT_EQ(client.ask({3, 0, 0, 0, 1}).size(), 11U) << "reading goes on";
}

TEST(ModbusServer, a_busy_port_is_one_clear_error) {
  Serving serving;
  ServePlan plan = Serving::plan();
  plan.port = serving.server.port();
  MonotonicClock clock;
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk orders;
  try {
    const ModbusServer second(plan, clock, {{units_of_one_spindle(), snapshots, signals, orders}});
    FAIL() << "no error";
  } catch (const rom::InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "serve: cannot listen on 127.0.0.1 port " + std::to_string(plan.port) + ": Address already in use");
  }
}

}  // namespace serve_modbus_server_test
}  // namespace spindle_twin::firmware

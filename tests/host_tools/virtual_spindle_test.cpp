#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <sys/socket.h>

#include <array>
#include <bit>
#include <functional>
#include <memory>
#include <thread>

#include "host_tools/virtual_spindle/plant_server.hpp"
#include "host_tools/virtual_spindle/plant_truth.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace virtual_spindle_test {

std::string message_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "no error";
}

rom::Boundaries small_boundaries() {
  rom::Boundaries boundaries;
  boundaries.sources = {{"front", 10.0, {}}, {"rear", 20.0, {}}};
  boundaries.environments = {{"air", rom::EnvironmentKind::ambient}, {"water", rom::EnvironmentKind::coolant}};
  for (const char* name : {"shaft/ring", "ring/seat", "seat/housing"}) {
    rom::Conductance contact;
    contact.name = name;
    boundaries.conductances.push_back(contact);
  }
  rom::Conductance film;
  film.name = "outside";
  film.kind = rom::ConductanceKind::environment_film;
  boundaries.conductances.push_back(film);
  return boundaries;
}

TEST(HiddenTruth, factors_land_on_what_they_name) {
  HiddenTruth truth;
  truth.heat_factors = {{"all", 0.5}, {"rear", 2.0}};
  truth.contact_factors = {{"ring/seat", 3.0}};
  truth.film_factors = {{"all", 0.25}};
  const rom::CorrectionFactors factors = hidden_factors(small_boundaries(), truth);
  EXPECT_EQ(factors.heat, Eigen::Vector2d(0.5, 1.0));
  EXPECT_EQ(factors.conductance, Eigen::Vector4d(1.0, 3.0, 1.0, 0.25));
}

TEST(HiddenTruth, contact_spread_stays_in_its_bounds_and_follows_its_seed) {
  HiddenTruth truth;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    truth.contact_spread = ContactSpread{seed, 2.0};
    const rom::CorrectionFactors factors = hidden_factors(small_boundaries(), truth);
    EXPECT_EQ(factors.conductance, hidden_factors(small_boundaries(), truth).conductance) << seed;
    EXPECT_GE(factors.conductance.head(3).minCoeff(), 0.5) << seed;
    EXPECT_LE(factors.conductance.head(3).maxCoeff(), 2.0) << seed;
    EXPECT_EQ(factors.conductance[3], 1.0) << "a film is no contact";
  }
}

TEST(HiddenTruth, names_and_numbers_that_do_not_fit_are_one_error) {
  HiddenTruth truth;
  truth.heat_factors = {{"midle", 1.0}};
  EXPECT_EQ(message_of([&] { hidden_factors(small_boundaries(), truth); }),
            "--heat-factor: 'midle' does not exist; allowed: all, front, rear");
  EXPECT_EQ(message_of([] { parse_named_value("front=-1", "--heat-factor"); }),
            "--heat-factor: '-1' is not a positive finite number");
  EXPECT_EQ(message_of([] { parse_named_value("front", "--heat-factor"); }),
            "--heat-factor: 'front' is not NAME=VALUE");
  EXPECT_EQ(parse_named_value("inner=-0.02", "--offset-K").value, -0.02);
  EXPECT_EQ(message_of([] { parse_contact_spread("7"); }), "--contact-spread: '7' is not SEED:FACTOR, as in 7:2.0");
  EXPECT_EQ(message_of([] { parse_contact_spread("7:0.5"); }), "--contact-spread: the factor must be at least 1");
}

PlantSnapshot some_snapshot() {
  PlantSnapshot snapshot;
  snapshot.time_s = 80.0;
  snapshot.steps = 65536 + 7;
  snapshot.operating = {6000.0, 0.5, Eigen::Vector2d(300.15, 295.15)};
  snapshot.measured_degC = {29.44, -3.21};
  snapshot.key_point_degC = {29.40, -3.2};
  snapshot.part_max_degC = {42.19};
  snapshot.deformation_um = {-12.5};
  return snapshot;
}

TEST(PlantRegisters, words_follow_the_published_map) {
  const PlantRegisters registers = encode_plant(small_boundaries(), some_snapshot());
  EXPECT_EQ(registers[0], 0x1234);
  EXPECT_EQ(registers[1], 1) << "labelled as simulated";
  EXPECT_EQ(registers[2], 7);
  EXPECT_EQ(registers[3], 2);
  EXPECT_EQ(registers[4], 6000);
  EXPECT_EQ(registers[5], 500);
  EXPECT_EQ(registers[6], 2200);
  EXPECT_EQ(registers[7], 2700);
  EXPECT_EQ(registers[8], 2944);
  EXPECT_EQ(registers[9], static_cast<std::uint16_t>(-321));
  EXPECT_EQ(registers[10], 0x8000) << "not fitted";
  EXPECT_EQ(registers[28], 0x8000) << "not in the schedule";
  EXPECT_EQ(registers[29], 0x8000);
  EXPECT_EQ(registers[102], 0xC148) << "-12.5 as float32, high word first";
  EXPECT_EQ(registers[103], 0x0000);
  EXPECT_EQ(std::bit_cast<float>(static_cast<std::uint32_t>(registers[142]) << 16 | registers[143]), 42.19f);
}

TEST(PlantRegisters, current_and_power_of_the_motor_are_shown_where_the_schedule_has_them) {
  PlantSnapshot snapshot = some_snapshot();
  snapshot.operating.current_A = 12.34;
  snapshot.operating.power_W = -1500.0;
  const PlantRegisters registers = encode_plant(small_boundaries(), snapshot);
  EXPECT_EQ(registers[28], 1234);
  EXPECT_EQ(registers[29], static_cast<std::uint16_t>(-150));
}

class Served : public ::testing::Test {
 protected:
  void SetUp() override {
    for (port_ = 16900; port_ < 17000 && !server_; ++port_) {
      try {
        server_ = std::make_unique<PlantServer>("127.0.0.1", port_);
        break;
      } catch (const rom::InputError&) {  // taken by another program: the next one
      }
    }
    ASSERT_NE(server_, nullptr);
    server_->publish(encode_plant(small_boundaries(), some_snapshot()));
    thread_ = std::thread([this] { server_->serve(stop_); });
  }
  void TearDown() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  using Client = std::unique_ptr<modbus_t, void (*)(modbus_t*)>;
  Client connect() const {
    Client client(modbus_new_tcp("127.0.0.1", port_), [](modbus_t* context) {
      modbus_close(context);
      modbus_free(context);
    });
    EXPECT_EQ(modbus_connect(client.get()), 0);
    return client;
  }

  int port_ = 0;
  std::unique_ptr<PlantServer> server_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST_F(Served, both_read_codes_show_the_same_and_writes_are_refused) {
  const Client client = connect();
  EXPECT_FALSE(server_->was_read());
  std::array<std::uint16_t, 125> inputs{};
  std::array<std::uint16_t, 125> holdings{};
  EXPECT_EQ(modbus_read_input_registers(client.get(), 0, 125, inputs.data()), 125);
  EXPECT_EQ(modbus_read_registers(client.get(), 0, 125, holdings.data()), 125);
  EXPECT_EQ(inputs, holdings);
  EXPECT_EQ(inputs[8], 2944);
  EXPECT_TRUE(server_->was_read());
  EXPECT_EQ(modbus_write_register(client.get(), 8, 0), -1);
  EXPECT_EQ(modbus_read_input_registers(client.get(), 8, 1, inputs.data()), 1);
  EXPECT_EQ(inputs[0], 2944);
  EXPECT_EQ(modbus_read_input_registers(client.get(), plant_register_count, 1, inputs.data()), -1);
}

TEST_F(Served, half_a_request_of_one_client_does_not_hold_up_another) {
  const Client slow = connect();
  const std::array<std::uint8_t, 5> half{0, 1, 0, 0, 0};
  ASSERT_EQ(::send(modbus_get_socket(slow.get()), half.data(), half.size(), 0), 5);
  const Client good = connect();
  modbus_set_response_timeout(good.get(), 0, 300000);
  std::uint16_t word = 0;
  EXPECT_EQ(modbus_read_input_registers(good.get(), 0, 1, &word), 1);
  EXPECT_EQ(word, 0x1234);
}

TEST_F(Served, busy_port_is_one_error) {
  EXPECT_EQ(message_of([&] { PlantServer second("127.0.0.1", port_); }),
            "--port: cannot listen on 127.0.0.1:" + std::to_string(port_) + ": Address already in use");
}

}  // namespace virtual_spindle_test
}  // namespace spindle_twin::host_tools

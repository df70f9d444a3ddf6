#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>

#include "firmware/serve/command_registers.hpp"
#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"

namespace spindle_twin::firmware {
namespace serve_registers_test {

Snapshot empty_snapshot() {
  Snapshot snapshot;
  snapshot.signals = {6000.0, 1.0, 300.0, 300.0};
  snapshot.nose_m = 0.0;
  return snapshot;
}

RegisterImage image_of(const Snapshot& snapshot, std::int64_t now_ns = 0) {
  RegisterImage image{};
  fill_image(snapshot, now_ns, image);
  return image;
}

std::uint16_t word(const RegisterImage& image, Register which, int offset = 0) {
  return image.at(static_cast<std::size_t>(entry_of(which).address + offset));
}

TEST(RegisterMap, no_two_registers_overlap) {
  std::set<int> taken;
  for (const RegisterEntry& entry : register_entries) {
    for (int at = entry.address; at < entry.address + entry.slots * words_of(entry.type); ++at) {
      EXPECT_TRUE(taken.insert(at).second) << entry.name << " at " << at;
    }
  }
}

TEST(RegisterMap, each_block_fits_one_read_and_holds_its_registers) {
  for (const RegisterBlock& block : register_blocks) EXPECT_LE(block.length, 125) << block.name;
  for (const RegisterEntry& entry : register_entries) {
    int homes = 0;
    for (const RegisterBlock& block : register_blocks) {
      const int end = entry.address + entry.slots * words_of(entry.type);
      if (entry.address >= block.address && end <= block.address + block.length) ++homes;
    }
    EXPECT_EQ(homes, 1) << entry.name;
  }
}

TEST(RegisterMap, printed_map_names_every_register) {
  const std::string markdown = register_map_markdown();
  const std::string csv = register_map_csv();
  for (const RegisterEntry& entry : register_entries) {
    EXPECT_NE(markdown.find(std::string("| ") + entry.name + " |"), std::string::npos) << entry.name;
    EXPECT_NE(csv.find(std::string("\n") + entry.name), std::string::npos) << entry.name;
  }
}

TEST(RegisterImage, known_answers_have_the_documented_words) {
  const RegisterImage image = image_of(empty_snapshot());
  EXPECT_EQ(word(image, Register::known_uint16), 0x1234);
  EXPECT_EQ(word(image, Register::known_int16), 0xFF83);
  EXPECT_EQ(word(image, Register::known_float32, 0), 0xC148);
  EXPECT_EQ(word(image, Register::known_float32, 1), 0x0000);
  EXPECT_EQ(word(image, Register::known_float32_cdab, 0), 0x0000);
  EXPECT_EQ(word(image, Register::known_float32_cdab, 1), 0xC148);
}

TEST(RegisterImage, every_word_of_every_readable_register_is_written) {
  RegisterImage zeros{};
  RegisterImage ones{};
  ones.fill(0xFFFF);
  const Snapshot snapshot = empty_snapshot();
  fill_image(snapshot, 0, zeros);
  fill_image(snapshot, 0, ones);
  for (const RegisterEntry& entry : register_entries) {
    if (entry.command) continue;
    for (int at = entry.address; at < entry.address + entry.slots * words_of(entry.type); ++at) {
      EXPECT_EQ(zeros.at(static_cast<std::size_t>(at)), ones.at(static_cast<std::size_t>(at)))
          << entry.name << " " << at;
    }
  }
}

TEST(RegisterImage, nose_stands_in_all_forms) {
  Snapshot snapshot = empty_snapshot();
  snapshot.nose_m = -15.46e-6;
  snapshot.nose_network_deviation_m = 0.02e-6;
  const RegisterImage image = image_of(snapshot);
  EXPECT_EQ(static_cast<std::int16_t>(word(image, Register::nose_int16)), -155);
  EXPECT_EQ(word(image, Register::nose_offset16), 32768 - 155);
  EXPECT_EQ(word(image, Register::nose_int32, 0), 0xFFFF);
  EXPECT_EQ(word(image, Register::nose_int32, 1), 0xFF65);
  EXPECT_FLOAT_EQ(static_cast<float>(get(image, Register::nose_float32)), -15.46F);
  EXPECT_EQ(word(image, Register::nose_network_sd), 20) << "0.001 um each";
  EXPECT_EQ(word(image, Register::nose_float32, 0), word(image, Register::nose_float32_cdab, 1));
  EXPECT_EQ(word(image, Register::nose_float32, 1), word(image, Register::nose_float32_cdab, 0));
}

TEST(RegisterImage, deviations_and_updates_of_the_estimator) {
  Snapshot snapshot = empty_snapshot();
  RegisterImage image = image_of(snapshot);
  EXPECT_EQ(word(image, Register::nose_sd), 0x7FC0);
  EXPECT_EQ(word(image, Register::key_point_sd), 0xFFFF);
  EXPECT_EQ(word(image, Register::sensor_update), 0xFFFF);
  EXPECT_EQ(word(image, Register::parameter_count), 0xFFFF);
  EXPECT_EQ(word(image, Register::calibrated_at), 0xFFFF);
  EXPECT_EQ(word(image, Register::calibration_promise), 0x7FC0);
  EXPECT_EQ(word(image, Register::displacement_innovation), 0x7FC0);

  snapshot.deformation_deviation_m[0] = 1.25e-6;
  snapshot.deformation_raw_m[0] = 5e-6;
  snapshot.tare_m = 2e-6;
  snapshot.predicted_deviation_K[1] = 0.0214;
  snapshot.sensor_update[1] = {303.15, -0.012, 1e-3, 80.0, 0.015, 0.02, bits(Update::rejected), 3};
  snapshot.parameters = 44;
  snapshot.parameters_determined = 10;
  snapshot.unexplained_heat_group = 2;
  snapshot.unexplained_heat_W = -12.34;
  snapshot.calibrated_unix_s = 1.7e9;
  snapshot.calibration_promised_m = 0.75e-6;
  snapshot.displacement_update = {5e-6, 1e-6, 4e-12, 0.01, not_a_value, not_a_value, bits(Update::fused), 0};
  image = image_of(snapshot);
  EXPECT_EQ(get(image, Register::calibrated_at), 1.7e9);
  EXPECT_FLOAT_EQ(static_cast<float>(get(image, Register::calibration_promise)), 0.75F);
  EXPECT_FLOAT_EQ(static_cast<float>(get(image, Register::nose_sd)), 1.25F);
  EXPECT_FLOAT_EQ(static_cast<float>(get(image, Register::deformation_sd)), 1.25F);
  EXPECT_FLOAT_EQ(static_cast<float>(get(image, Register::nose_raw)), 3.0F);
  EXPECT_EQ(word(image, Register::key_point_sd, 1), 21);
  EXPECT_EQ(word(image, Register::sensor_observation, 1), 3000);
  EXPECT_EQ(static_cast<std::int16_t>(word(image, Register::sensor_innovation, 1)), -12);
  EXPECT_FLOAT_EQ(static_cast<float>(get(image, Register::sensor_variance, 1)), 1e-3F);
  EXPECT_EQ(word(image, Register::sensor_test_ratio, 1), 65534) << "clipped, which is no clipped prediction";
  EXPECT_EQ(word(image, Register::quality) & bits(Quality::saturated), 0);
  EXPECT_EQ(word(image, Register::sensor_update, 1), bits(Update::rejected));
  EXPECT_EQ(word(image, Register::sensor_offset, 1), 15);
  EXPECT_EQ(word(image, Register::parameters_determined), 10);
  EXPECT_EQ(word(image, Register::unexplained_heat_group), 2);
  EXPECT_EQ(static_cast<std::int16_t>(word(image, Register::unexplained_heat)), -123);
  EXPECT_FLOAT_EQ(static_cast<float>(get(image, Register::displacement_innovation_sd)), 2.0F);
}

TEST(RegisterImage, a_clipped_value_raises_the_saturation_bit) {
  Snapshot snapshot = empty_snapshot();
  snapshot.nose_m = 3.2767e-3;
  RegisterImage image = image_of(snapshot);
  EXPECT_EQ(word(image, Register::nose_int16), 32767);
  EXPECT_EQ(word(image, Register::quality) & bits(Quality::saturated), 0);
  snapshot.nose_m = -3.4e-3;
  image = image_of(snapshot);
  EXPECT_EQ(static_cast<std::int16_t>(word(image, Register::nose_int16)), -32767);
  EXPECT_EQ(word(image, Register::nose_offset16), 1);
  EXPECT_NE(word(image, Register::quality) & bits(Quality::saturated), 0);
  EXPECT_DOUBLE_EQ(get(image, Register::nose_int32), -3400.0);
}

TEST(RegisterImage, absent_values_are_not_present_and_not_saturated) {
  Snapshot snapshot = empty_snapshot();
  snapshot.nose_m = not_a_value;
  const RegisterImage image = image_of(snapshot);
  EXPECT_EQ(word(image, Register::nose_int16), 0x8000);
  EXPECT_EQ(word(image, Register::nose_offset16), 0);
  EXPECT_EQ(word(image, Register::nose_float32, 0), 0x7FC0);
  EXPECT_EQ(word(image, Register::key_point_measured, 15), 0x8000);
  EXPECT_EQ(word(image, Register::heat_factor, 15), 0xFFFF);
  EXPECT_EQ(word(image, Register::quality) & bits(Quality::saturated), 0);
}

TEST(RegisterImage, heartbeat_wraps_over_all_words) {
  Snapshot snapshot = empty_snapshot();
  snapshot.sequence = 65535;
  EXPECT_EQ(word(image_of(snapshot), Register::heartbeat), 65535);
  snapshot.sequence = 65536;
  EXPECT_EQ(word(image_of(snapshot), Register::heartbeat), 0);
  EXPECT_DOUBLE_EQ(get(image_of(snapshot), Register::parts_sequence), 65536.0);
}

TEST(RegisterImage, prediction_age_is_the_time_since_the_cycle) {
  Snapshot snapshot = empty_snapshot();
  snapshot.time_ns = 5'000'000'000;
  EXPECT_NEAR(get(image_of(snapshot, 5'250'000'000), Register::prediction_age), 0.25, 1e-9);
}

TEST(Pack, get_inverts_put_for_every_type) {
  RegisterImage image{};
  for (const Register which : {Register::speed, Register::nose_int16, Register::nose_offset16, Register::nose_int32,
                               Register::overruns, Register::nose_float32, Register::nose_float32_cdab}) {
    const double value = 1234.0;
    EXPECT_TRUE(put(image, which, value));
    EXPECT_NEAR(get(image, which), value, 1e-9) << entry_of(which).name;
    put_not_present(image, which);
    EXPECT_TRUE(std::isnan(get(image, which))) << entry_of(which).name;
  }
}

TEST(Commands, only_what_was_written_counts_as_read) {
  RegisterImage image{};
  clear_commands(image);
  PlcSignals told;
  put(image, Register::command_speed, 6000.0);
  put(image, Register::command_load, 55.5);
  EXPECT_TRUE(take_signals({entry_of(Register::command_speed).address, 1}, 77, image, told).test(0));
  EXPECT_EQ(told.values[0].value, 6000.0);
  EXPECT_EQ(told.values[0].time_ns, 77);
  EXPECT_EQ(told.values[1].time_ns, 0);
  EXPECT_TRUE(take_signals({entry_of(Register::command_speed).address, 2}, 78, image, told).test(1));
  EXPECT_NEAR(told.values[1].value, 0.555, 1e-12);
  EXPECT_TRUE(take_signals({entry_of(Register::command_tare).address, 1}, 79, image, told).none());
  EXPECT_TRUE(take_orders(writable_registers(), {}, image).empty());
}

TEST(Commands, tare_order_is_taken_once_and_reads_back_as_zero) {
  RegisterImage image{};
  clear_commands(image);
  put(image, Register::command_tare, 2.0);
  put(image, Register::command_order_id, 4711.0);
  const std::vector<Order> orders = take_orders(writable_registers(), {}, image);
  ASSERT_EQ(orders.size(), 1U);
  EXPECT_EQ(orders[0].kind, OrderKind::tare);
  EXPECT_EQ(orders[0].code, 2);
  EXPECT_EQ(orders[0].id, 4711);
  EXPECT_EQ(get(image, Register::command_tare), 0.0);
  EXPECT_TRUE(take_orders(writable_registers(), {}, image).empty());
}

TEST(Commands, the_switch_is_an_order_only_where_it_changes) {
  RegisterImage image{};
  clear_commands(image);
  put(image, Register::command_correction, 0.0);
  EXPECT_EQ(take_orders(writable_registers(), {1, not_present_code}, image).size(), 1U);
  EXPECT_EQ(take_orders(writable_registers(), {0, not_present_code}, image).size(), 0U)
      << "a PLC may write all registers each second";
  put_not_present(image, Register::command_correction);
  const std::vector<Order> orders = take_orders(writable_registers(), {0, not_present_code}, image);
  ASSERT_EQ(orders.size(), 1U);
  EXPECT_EQ(orders[0].code, not_present_code);
}

TEST(Commands, the_compensation_has_a_switch_of_its_own) {
  RegisterImage image{};
  clear_commands(image);
  put(image, Register::command_correction, 1.0);
  put(image, Register::command_compensation, 0.0);
  const std::vector<Order> orders = take_orders(writable_registers(), {1, not_present_code}, image);
  ASSERT_EQ(orders.size(), 1U);
  EXPECT_EQ(orders[0].kind, OrderKind::compensation);
  EXPECT_EQ(orders[0].code, 0);
  EXPECT_TRUE(take_orders(writable_registers(), {1, 0}, image).empty());
}

TEST(Commands, a_measured_length_is_taken_with_its_deviation_and_output) {
  RegisterImage image{};
  clear_commands(image);
  const auto take = [&](WriteRange written) { return take_orders(written, {}, image); };
  put(image, Register::command_displacement, -3.5);
  put(image, Register::command_displacement_sd, 1.0);
  EXPECT_TRUE(take({entry_of(Register::command_displacement).address, 4}).empty()) << "not before it is ordered";
  put(image, Register::command_displacement_take, 1.0);
  const std::vector<Order> first = take(writable_registers());
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].kind, OrderKind::length);
  EXPECT_EQ(first[0].length.output, 0U);
  EXPECT_NEAR(first[0].length.value_m, -3.5e-6, 1e-12);
  EXPECT_NEAR(first[0].length.deviation_m, 1e-6, 1e-12);
  EXPECT_EQ(get(image, Register::command_displacement_take), 0.0);
  put(image, Register::command_displacement_output, 1.0);
  put(image, Register::command_displacement_take, 1.0);
  const std::vector<Order> second = take(writable_registers());
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].length.output, 1U);
}

}  // namespace serve_registers_test
}  // namespace spindle_twin::firmware

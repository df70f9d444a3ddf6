#include "firmware/serve/pack.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace spindle_twin::firmware {
namespace serve_pack_test {

struct WholeType {
  Register which;
  double least, most;      ///< counts
  std::uint32_t absent;    ///< its words, as one number
  std::uint32_t at_least;  ///< the words of its least count
};

const WholeType whole_types[] = {
    {Register::speed, 0.0, 65534.0, 0xFFFFU, 0U},
    {Register::nose_int16, -32767.0, 32767.0, 0x8000U, 0x8001U},
    {Register::nose_offset16, -32767.0, 32767.0, 0x0000U, 0x0001U},
    {Register::overruns, 0.0, 4294967294.0, 0xFFFFFFFFU, 0U},
    {Register::nose_int32, -2147483647.0, 2147483647.0, 0x80000000U, 0x80000001U},
};

std::uint32_t words(const RegisterImage& image, Register which) {
  const RegisterEntry& entry = entry_of(which);
  const std::uint32_t first = image.at(entry.address);
  return words_of(entry.type) == 1 ? first : first << 16U | image.at(entry.address + std::size_t{1});
}

TEST(PackLimits, a_count_is_clipped_beyond_its_limits_and_never_says_not_present) {
  for (const WholeType& type : whole_types) {
    const RegisterEntry& entry = entry_of(type.which);
    RegisterImage image{};
    const auto put_count = [&](double count) { return put(image, type.which, count * entry.resolution); };
    for (const auto& [limit, beyond] : {std::pair{type.least, type.least - 1.0}, {type.most, type.most + 1.0}}) {
      EXPECT_TRUE(put_count(limit)) << entry.name;
      EXPECT_NEAR(get(image, type.which) / entry.resolution, limit, 1e-3) << entry.name;
      EXPECT_FALSE(put_count(beyond)) << entry.name;
      EXPECT_NEAR(get(image, type.which) / entry.resolution, limit, 1e-3) << entry.name;
      EXPECT_NE(words(image, type.which), type.absent) << entry.name;
    }
    put_count(type.least);
    EXPECT_EQ(words(image, type.which), type.at_least) << entry.name;
    EXPECT_TRUE(put(image, type.which, std::numeric_limits<double>::quiet_NaN())) << "absent is not clipped";
    EXPECT_EQ(words(image, type.which), type.absent) << entry.name;
  }
}

TEST(PackLimits, a_count_is_the_nearest_and_halves_go_away_from_zero) {
  RegisterImage image{};
  for (const auto& [value, count] : {std::pair{1.2, 1.0}, {1.5, 2.0}, {2.5, 3.0}, {-1.2, -1.0}, {-1.5, -2.0}}) {
    for (const Register which : {Register::nose_int16, Register::nose_offset16, Register::nose_int32}) {
      const double resolution = entry_of(which).resolution;
      EXPECT_TRUE(put(image, which, value * resolution));
      EXPECT_NEAR(get(image, which), count * resolution, 1e-9) << entry_of(which).name << " " << value;
    }
  }
}

TEST(PackLimits, a_float_keeps_its_fraction_and_is_clipped_where_floats_end) {
  constexpr double most = std::numeric_limits<float>::max();
  for (const Register which : {Register::nose_float32, Register::nose_float32_cdab}) {
    RegisterImage image{};
    EXPECT_TRUE(put(image, which, 0.375));
    EXPECT_EQ(get(image, which), 0.375);
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_TRUE(put(image, which, sign * most));
      EXPECT_FALSE(put(image, which, 2.0 * sign * most));
      EXPECT_EQ(get(image, which), sign * most);
    }
  }
}

TEST(PackLimits, two_words_go_high_first_but_for_cdab) {
  RegisterImage image{};
  put(image, Register::overruns, 0x12345678);
  EXPECT_EQ(image.at(entry_of(Register::overruns).address), 0x1234);
  EXPECT_EQ(image.at(entry_of(Register::overruns).address + std::size_t{1}), 0x5678);
  put(image, Register::nose_float32_cdab, 1.0000001);  // 3F80 0001
  EXPECT_EQ(image.at(entry_of(Register::nose_float32_cdab).address), 0x0001);
  EXPECT_EQ(image.at(entry_of(Register::nose_float32_cdab).address + std::size_t{1}), 0x3F80);
}

TEST(PackLimits, a_slot_is_written_where_it_stands_and_nowhere_else) {
  for (const Register which : {Register::part_maximum, Register::heat_factor, Register::device_accepted,
                               Register::key_point_measured_float32}) {
    const RegisterEntry& entry = entry_of(which);
    for (int slot = 0; slot < entry.slots; ++slot) {
      RegisterImage image{};
      image.fill(0xAAAA);
      put(image, which, 3.0, slot);
      const int first = entry.address + slot * words_of(entry.type), end = first + words_of(entry.type);
      for (int at = 0; at < static_cast<int>(image.size()); ++at) {
        EXPECT_EQ(image.at(static_cast<std::size_t>(at)) != 0xAAAA, first <= at && at < end) << entry.name << " " << at;
      }
      EXPECT_NEAR(get(image, which, slot), 3.0, 1e-9);
    }
  }
}

}  // namespace serve_pack_test
}  // namespace spindle_twin::firmware

#include "rom/read/options.hpp"

#include <gtest/gtest.h>

#include "tests/support/texts.hpp"

namespace spindle_twin::rom::tests {
namespace options_test {

using spindle_twin::tests::refusal_of;

constexpr Option some = zero_or_some("some", "none at all, or so much", 5.0);
constexpr Option warmth{"warmth_degC", "in kelvin within", between(-10.0, 40.0), false, 273.15};
constexpr Option count{"count", "a whole number", between(2, 9)};

double read(const Option& option, const std::string& written, double before) {
  double value = before;
  ReadOptions(TomlTable::parse(std::string(option.key) + " = " + written + "\n", "f.toml"))(option, value);
  return value;
}

TEST(Options, a_deviation_is_none_or_one_that_a_covariance_can_hold) {
  for (const double good : {0.0, 1e-9, 2e-9, 1.0, 5.0}) {
    EXPECT_EQ(refusal_of([&] { CheckOptions("filter.")(some, good); }), "accepted") << good;
  }
  for (const double small : {1e-12, 0.9e-9}) {
    EXPECT_EQ(refusal_of([&] { CheckOptions("filter.")(some, small); }), "filter.some: must be 0 or at least 1e-9");
  }
  for (const double wrong : {-1e-12, 5.1}) {
    EXPECT_EQ(refusal_of([&] { CheckOptions("filter.")(some, wrong); }), "filter.some: must be a number from 0 to 5");
  }
  EXPECT_EQ(read(some, "0.0", 3.0), 0.0);
  EXPECT_EQ(read(some, "1e-9", 3.0), 1e-9);
  EXPECT_EQ(refusal_of([] { read(some, "0.9e-9", 3.0); }), "f.toml:1: some: must be 0 or at least 1e-9");
  EXPECT_EQ(refusal_of([] {
              CheckOptions()({"other", "", between(0.0, 5.0)}, 1e-12);
            }),
            "accepted")
      << "where none of it is no case of its own";
}

TEST(Options, are_written_in_a_unit_that_may_have_another_zero) {
  EXPECT_DOUBLE_EQ(read(warmth, "20.0", 0.0), 293.15);
  EXPECT_DOUBLE_EQ(read(warmth, "-10.0", 0.0), 263.15);
  EXPECT_EQ(refusal_of([] { read(warmth, "41.0", 0.0); }),
            "f.toml:1: warmth_degC: must be a number from -10 to 40, is 41");
  EXPECT_EQ(refusal_of([] { CheckOptions()(warmth, 273.15 + 40.0); }), "accepted");
  EXPECT_EQ(refusal_of([] { CheckOptions()(warmth, 273.15 + 41.0); }), "warmth_degC: must be a number from -10 to 40");
  EXPECT_EQ(refusal_of([] { CheckOptions()(warmth, 40.0); }), "warmth_degC: must be a number from -10 to 40");
}

TEST(Options, keep_what_they_were_where_nothing_is_written_and_a_narrower_range_takes_the_place_of_their_own) {
  const TomlTable table = TomlTable::parse("count = 7\nsome = 2.0\n", "f.toml");
  int number = 3;
  double kept = 300.0, deviation = 0.0;
  bool on = true;
  ReadOptions read_these(table);
  read_these(count, number);
  read_these(warmth, kept);
  read_these({"switch", ""}, on);
  EXPECT_EQ(number, 7);
  EXPECT_EQ(kept, 300.0);
  EXPECT_TRUE(on);
  read_these.narrow("some", between(0.0, 1.5)).narrow("count", between(2, 6));
  EXPECT_EQ(refusal_of([&] { read_these(some, deviation); }), "f.toml:2: some: must be a number from 0 to 1.5, is 2");
  EXPECT_EQ(refusal_of([&] { read_these(count, number); }), "f.toml:1: count: must be an integer from 2 to 6, is 7");
  CheckOptions()(count, 9);
  EXPECT_EQ(refusal_of([&] { CheckOptions()(count, 10); }), "count: must be a number from 2 to 9");
}

}  // namespace options_test
}  // namespace spindle_twin::rom::tests

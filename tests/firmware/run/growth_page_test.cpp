#include "firmware/run/growth_page.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "rom/read/input_error.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace run_growth_page_test {

using correction::ReadingOrigin;

TEST(GrowthPage, holds_the_judgement_of_the_whole_and_of_each_week_in_um) {
  constexpr double monday_s = 1'793'577'600.0;  // 2 November 2026
  FoundTouchOffs found{true, {{"no\"se", 2, {}}, {"flange", 2, {}}}};
  for (int n = 0; n < 5; ++n) {
    found.outputs[0].readings.push_back({monday_s + 3600.0 * n, 0, ReadingOrigin::touch_off, -2e-6 * n, 1e-6 * n});
  }
  const nlohmann::json page = nlohmann::json::parse(growth_json(found));
  EXPECT_EQ(page.at("is_whole"), true);
  ASSERT_EQ(page.at("outputs").size(), 2U);
  const nlohmann::json& nose = page["outputs"][0];
  EXPECT_EQ(nose.at("output"), "no\"se");
  EXPECT_EQ(nose.at("touch_offs"), 5);
  EXPECT_EQ(nose.at("stretches"), 2);
  EXPECT_EQ(nose.at("from_unix_s"), monday_s);
  EXPECT_EQ(nose.at("measured_times"), -2.0);
  EXPECT_EQ(nose.at("whole").at("readings"), 4);
  EXPECT_EQ(nose.at("whole").at("growth_worst_um"), -8.0);
  EXPECT_EQ(nose.at("whole").at("left_worst_um"), -12.0);
  EXPECT_EQ(nose.at("whole").at("verdict"), "makes it worse");
  ASSERT_EQ(nose.at("weeks").size(), 1U);
  EXPECT_EQ(nose["weeks"][0].at("from_unix_s"), monday_s);
  EXPECT_EQ(nose["weeks"][0].at("left_rms_um"), nose["whole"].at("left_rms_um"));
  const nlohmann::json& flange = page["outputs"][1];
  EXPECT_TRUE(flange.at("from_unix_s").is_null());
  EXPECT_TRUE(flange.at("measured_times").is_null());
  EXPECT_EQ(flange.at("whole").at("verdict"), "too few readings");
}

TEST(GrowthPage, there_is_none_without_a_database_or_without_a_deformation) {
  rom::Network network = tests::small_network();
  EXPECT_FALSE(growth_page({"history.csv"}, network));
  const auto page = growth_page({"/nowhere/history.sqlite"}, network);
  ASSERT_TRUE(page);
  EXPECT_THROW(page(false), rom::InputError);
  network.deformations.clear();
  EXPECT_FALSE(growth_page({"history.sqlite"}, network));
}

}  // namespace run_growth_page_test
}  // namespace spindle_twin::firmware

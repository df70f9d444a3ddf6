#include "firmware/run/growth_page.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "firmware/cycle/publish.hpp"
#include "firmware/keep/sqlite_history.hpp"
#include "rom/read/input_error.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"

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
  EXPECT_EQ(nose.at("whole").at("growth_rms_um"), 5.477);
  EXPECT_EQ(nose.at("whole").at("left_rms_um"), 8.216);
  EXPECT_EQ(nose.at("whole").at("verdict"), "makes it worse");
  ASSERT_EQ(nose.at("weeks").size(), 1U);
  EXPECT_EQ(nose["weeks"][0].at("from_unix_s"), monday_s);
  EXPECT_EQ(nose["weeks"][0].at("left_rms_um"), nose["whole"].at("left_rms_um"));
  const nlohmann::json& flange = page["outputs"][1];
  EXPECT_TRUE(flange.at("from_unix_s").is_null());
  EXPECT_TRUE(flange.at("measured_times").is_null());
  EXPECT_EQ(flange.at("whole").at("verdict"), "too few readings");
}

TEST(GrowthPage, tells_whole_seconds_and_thousandths) {
  FoundTouchOffs found{true, {{"nose", 1, {}}}};
  for (int n = 0; n < 5; ++n) {
    found.outputs[0].readings.push_back({1000.25 + n, 0, ReadingOrigin::touch_off, 1e-6 * n, 3e-6 * n});
  }
  const nlohmann::json nose = nlohmann::json::parse(growth_json(found)).at("outputs").at(0);
  EXPECT_EQ(nose.at("from_unix_s"), 1000);
  EXPECT_EQ(nose.at("measured_times"), 0.333);
}

TEST(GrowthPage, of_a_daemon_that_is_being_stopped_it_is_not_whole) {
  const tests::TemporaryFolder folder;
  const rom::Network network = tests::small_network();
  Troubles troubles;
  SqliteHistory history({folder.file("history.sqlite")}, network, troubles);
  Snapshot snapshot = first_snapshot(network);
  for (snapshot.sequence = 1; snapshot.sequence <= 40; ++snapshot.sequence) {
    snapshot.displacement_orders = static_cast<std::uint32_t>(snapshot.sequence / 2);
    ASSERT_TRUE(history.ring().push(snapshot));
  }
  history.run(std::atomic<bool>(true));
  for (const bool stops : {false, true}) {
    const Page page = growth_page({folder.file("history.sqlite")}, network)(stops);
    EXPECT_EQ(page.status, 200);
    EXPECT_EQ(page.body.back(), '\n');
    EXPECT_EQ(nlohmann::json::parse(page.body).at("is_whole"), !stops);
  }
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

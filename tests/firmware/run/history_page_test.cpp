#include "firmware/run/history_page.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/keep/history_row.hpp"
#include "firmware/keep/sqlite_history.hpp"
#include "rom/read/input_error.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace run_history_page_test {

TEST(HistoryPage, holds_numbers_in_three_lists_of_a_column_and_null_where_there_is_none) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  const ThinnedHours hours{48.0, true, {1.8e9, 1.8e9 + 24.5}, {{"a \"b\"", {1.0F, none}, {1.25F, none}, {2.0F, none}}}};
  const nlohmann::json page = nlohmann::json::parse(thinned_json(8, hours));
  EXPECT_EQ(page.at("hours"), 8);
  EXPECT_EQ(page.at("span_s"), 48);
  EXPECT_EQ(page.at("is_whole"), true);
  EXPECT_EQ(page.at("unix_s"), nlohmann::json({1.8e9, 1.8e9 + 24.5}));
  const nlohmann::json& column = page.at("columns").at("a \"b\"");
  EXPECT_EQ(column.at("min"), nlohmann::json({1.0, nullptr}));
  EXPECT_EQ(column.at("mean"), nlohmann::json({1.25, nullptr}));
  EXPECT_EQ(column.at("max"), nlohmann::json({2.0, nullptr}));
}

TEST(HistoryPage, of_no_rows_is_whole_too) {
  const nlohmann::json page = nlohmann::json::parse(thinned_json(1, {6.0, true, {}, {{"a", {}, {}, {}}}}));
  EXPECT_TRUE(page.at("columns").at("a").at("mean").empty());
}

TEST(HistoryPage, its_columns_are_columns_of_the_history) {
  rom::Network network = tests::small_network();
  for (const bool has_nose : {true, false}) {
    std::istringstream header(history_header(network));
    std::vector<std::string> names;
    for (std::string name; std::getline(header, name, ',');) names.push_back(name);
    const std::vector<std::string> columns = shown_columns(network);
    for (const std::string& column : columns) EXPECT_EQ(std::count(names.begin(), names.end(), column), 1) << column;
    EXPECT_EQ(columns.size(), (has_nose ? 3 : 0) + 3 * network.key_points.size());
    network.deformations.clear();
  }
}

TEST(HistoryPage, there_is_none_of_a_history_that_is_no_database) {
  EXPECT_FALSE(history_page({"history.csv"}, tests::small_network()));
  EXPECT_FALSE(history_page({""}, tests::small_network()));
  const auto page = history_page({"/nowhere/history.sqlite"}, tests::small_network());
  ASSERT_TRUE(page);
  EXPECT_THROW(page(1, false), rom::InputError);
}

TEST(HistoryPage, of_a_daemon_that_is_being_stopped_it_is_not_whole) {
  const tests::TemporaryFolder folder;
  const rom::Network network = tests::small_network();
  Troubles troubles;
  SqliteHistory history({folder.file("history.sqlite")}, network, troubles);
  for (const bool stops : {false, true}) {
    const Page page = history_page({folder.file("history.sqlite")}, network)(1, stops);
    EXPECT_EQ(page.status, 200);
    EXPECT_EQ(page.body.back(), '\n');
    EXPECT_EQ(nlohmann::json::parse(page.body).at("is_whole"), !stops);
  }
}

}  // namespace run_history_page_test
}  // namespace spindle_twin::firmware

#include "firmware/keep/history.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace {

long commas(const std::string& text) { return std::count(text.begin(), text.end(), ','); }

TEST(History, a_row_has_a_field_per_column_and_absent_values_are_empty) {
  const rom::Network network = tests::small_network();
  Snapshot snapshot = first_snapshot(network);
  snapshot.nose_m = 1.5e-6;
  const std::string header = history_header(network);
  const std::string row = history_row(snapshot);
  EXPECT_EQ(commas(header), commas(row));
  EXPECT_NE(header.find(",measured.sleeve_inner_degC,"), std::string::npos);
  EXPECT_NE(header.find(",heat_factor.bearing,"), std::string::npos);
  EXPECT_NE(header.find(",deformation_sd.nose_um,"), std::string::npos);
  EXPECT_NE(header.find(",innovation.sleeve_outer_K,"), std::string::npos);
  EXPECT_NE(row.find(",1.5,"), std::string::npos);
  EXPECT_EQ(row.find("nan"), std::string::npos);
}

TEST(History, every_snapshot_becomes_a_row_in_order) {
  const rom::Network network = tests::small_network();
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  std::atomic<bool> stop{false};
  constexpr int rows = 500;
  {
    History history(path, network);
    std::thread writer([&] { history.run(stop); });
    Snapshot snapshot = first_snapshot(network);
    for (int n = 1; n <= rows; ++n) {
      snapshot.sequence = static_cast<std::uint32_t>(n);
      while (!history.ring().push(snapshot)) std::this_thread::yield();
    }
    stop.store(true);
    writer.join();
  }
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, history_header(network));
  int n = 0;
  while (std::getline(file, line)) EXPECT_EQ(line.rfind("0," + std::to_string(++n) + ",", 0), 0U) << line;
  EXPECT_EQ(n, rows);
}

TEST(History, a_path_that_cannot_be_written_is_one_clear_error) {
  try {
    const History history("/nonexistent/history.csv", tests::small_network());
    FAIL() << "no error";
  } catch (const rom::InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "/nonexistent/history.csv: history.path: cannot be written: No such file or directory");
  }
}

}  // namespace
}  // namespace spindle_twin::firmware

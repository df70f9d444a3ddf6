#include "firmware/keep/history.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace keep_history_test {

TEST(History, every_snapshot_becomes_a_row_in_order) {
  const rom::Network network = tests::small_network();
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  std::atomic<bool> stop{false};
  constexpr int rows = 500;
  {
    Troubles troubles;
    History history({path}, network, troubles);
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

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Writes the rows of these cycles and ends.
void write_cycles(History& history, std::uint64_t first, std::uint64_t last) {
  std::atomic<bool> stop{false};
  std::thread writer([&] { history.run(stop); });
  Snapshot snapshot = first_snapshot(tests::small_network());
  for (snapshot.sequence = first; snapshot.sequence <= last; ++snapshot.sequence) {
    while (!history.ring().push(snapshot)) std::this_thread::yield();
  }
  stop.store(true);
  writer.join();
}

TEST(History, what_runs_before_wrote_stays_and_a_row_that_was_torn_is_cut_off) {
  const rom::Network network = tests::small_network();
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  Troubles troubles;
  {
    History history({path}, network, troubles);
    write_cycles(history, 1, 3);
  }
  const std::string first = text_of(path);
  std::ofstream(path, std::ios::app) << "0,4,1,0,0.5";  // and then the power went
  {
    History history({path}, network, troubles);
    write_cycles(history, 1, 2);
  }
  { const History without_a_row({path}, network, troubles); }
  const History again({path}, network, troubles);
  ASSERT_EQ(earlier_histories(path),
            (std::vector<std::string>{folder.file("history.000001.csv"), folder.file("history.000002.csv")}));
  EXPECT_EQ(text_of(folder.file("history.000001.csv")), first);
  EXPECT_EQ(text_of(path), history_header(network) + "\n");
}

TEST(History, what_follows_a_hole_that_a_power_cut_left_is_cut_off_with_the_row_it_begins_in) {
  const rom::Network network = tests::small_network();
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  Troubles troubles;
  {
    History history({path}, network, troubles);
    write_cycles(history, 1, 1000);
  }
  const std::string whole = text_of(path);
  ASSERT_GT(whole.size(), 100'000U) << "longer than what is read at once";
  for (const std::size_t hole : {whole.size() - 700, std::size_t{70'000}, std::size_t{3}}) {
    std::filesystem::remove(folder.file("history.000001.csv"));
    std::string holed = whole;
    holed.replace(hole, 500, 500, '\0');
    std::ofstream(path, std::ios::binary) << holed;
    const History next({path}, network, troubles);
    const std::string kept = whole.substr(0, whole.rfind('\n', hole - 1) + 1);
    EXPECT_EQ(text_of(folder.file("history.000001.csv")), hole == 3 ? "" : kept);
    EXPECT_EQ(text_of(path), history_header(network) + "\n");
  }
}

TEST(History, is_bounded_and_begins_a_file_at_each_gap) {
  const rom::Network network = tests::small_network();
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  Troubles troubles;
  constexpr std::uint64_t segment = 16384, most = 65536;
  History history({path, segment, most}, network, troubles);
  write_cycles(history, 1, 1000);
  std::uint64_t bytes = std::filesystem::file_size(path);
  const std::vector<std::string> files = earlier_histories(path);
  for (const std::string& file : files) bytes += std::filesystem::file_size(file);
  EXPECT_GT(files.size(), 1U);
  EXPECT_LE(bytes, most + segment / 2) << "a row and a header more";
  EXPECT_FALSE(std::filesystem::exists(folder.file("history.000001.csv")));
  EXPECT_EQ(history.lost().load(), 0U);
  const std::size_t before = earlier_histories(path).size();
  write_cycles(history, 2000, 2001);
  EXPECT_GE(earlier_histories(path).size(), before);
  EXPECT_NE(text_of(path).find("\n0,2000,"), std::string::npos);
  EXPECT_EQ(text_of(path).find("\n0,1000,"), std::string::npos) << "each file replays by itself";
}

TEST(History, begins_a_file_at_a_gap_behind_its_very_first_row_and_none_in_front_of_it) {
  const rom::Network network = tests::small_network();
  for (const std::uint64_t first : {1U, 7U}) {
    const tests::TemporaryFolder folder;
    const std::string path = folder.file("history.csv");
    Troubles troubles;
    History history({path, 1U << 20U, 1U << 24U}, network, troubles);
    write_cycles(history, first, first);
    EXPECT_TRUE(earlier_histories(path).empty()) << first;
    write_cycles(history, first + 2, first + 2);
    EXPECT_EQ(earlier_histories(path).size(), 1U) << first;
    EXPECT_EQ(text_of(path).find("\n0," + std::to_string(first) + ","), std::string::npos) << first;
  }
}

TEST(History, keeps_a_thousand_files_however_small) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  for (int k = 100001; k <= 101002; ++k) std::ofstream(folder.file("history." + std::to_string(k) + ".csv")) << "1\n";
  EXPECT_EQ(remove_oldest_histories(path, 1'000'000), 2000U);
  const std::vector<std::string> left = earlier_histories(path);
  EXPECT_EQ(left.size(), 1000U);
  EXPECT_EQ(left.front(), folder.file("history.100003.csv"));
}

TEST(History, an_unwritable_folder_is_a_fault_and_not_the_end_and_it_is_tried_again) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("away/history.csv");
  Troubles troubles;
  History history({path}, tests::small_network(), troubles);
  EXPECT_NE(troubles.faults() & bits(Fault::history_lost), 0);
  write_cycles(history, 1, 5);
  EXPECT_EQ(troubles.history_rows_lost.load(), 5U);
  std::filesystem::create_directory(folder.file("away"));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  write_cycles(history, 6, 8);
  EXPECT_EQ(troubles.faults(), 0);
  EXPECT_EQ(troubles.history_rows_lost.load(), 5U);
  const std::string text = text_of(path);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
}

/// A process's limit of file sizes stands for a full disk: a row is written in part.
TEST(History, what_a_full_disk_leaves_of_a_row_is_cut_off) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  Troubles troubles;
  History history({path}, tests::small_network(), troubles);
  write_cycles(history, 1, 10);
  const auto whole = std::filesystem::file_size(path);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{whole + 100, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  write_cycles(history, 11, 20);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, ignored);
  EXPECT_EQ(std::filesystem::file_size(path), whole);
  EXPECT_NE(troubles.faults() & bits(Fault::history_lost), 0);
  EXPECT_EQ(troubles.history_rows_lost.load(), 10U);
}

}  // namespace keep_history_test
}  // namespace spindle_twin::firmware

#include "firmware/keep/history.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/firmware/support/logged.hpp"
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

TEST(History, one_that_is_removed_or_moved_away_while_it_is_written_is_begun_anew) {
  const rom::Network network = tests::small_network();
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  Troubles troubles;
  History history({path}, network, troubles);
  write_cycles(history, 1, 3);
  std::filesystem::remove(path);
  write_cycles(history, 4, 5);
  EXPECT_EQ(text_of(path).substr(0, history_header(network).size()), history_header(network));
  EXPECT_EQ(std::ranges::count(text_of(path), '\n'), 3);
  std::filesystem::rename(path, folder.file("elsewhere.csv"));
  write_cycles(history, 6, 6);
  EXPECT_EQ(std::ranges::count(text_of(path), '\n'), 2) << "the head and the row behind it";
  EXPECT_EQ(troubles.faults() & bits(Fault::history_lost), 0);
}

TEST(History, one_that_somebody_empties_while_it_is_written_is_begun_anew_and_said) {
  const rom::Network network = tests::small_network();
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  Troubles troubles;
  const Logged log;
  History history({path}, network, troubles);
  write_cycles(history, 1, 9);
  std::filesystem::resize_file(path, 0);
  write_cycles(history, 10, 11);
  EXPECT_EQ(text_of(path).substr(0, history_header(network).size()), history_header(network));
  EXPECT_EQ(std::ranges::count(text_of(path), '\n'), 3) << "the head and the rows behind it";
  EXPECT_EQ(text_of(path).find('\0'), std::string::npos);
  EXPECT_NE(log.text().find("somebody has emptied it"), std::string::npos);
  EXPECT_EQ(troubles.faults() & bits(Fault::history_lost), 0);
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

TEST(History, of_the_oldest_as_many_go_as_the_bytes_ask_for_and_all_behind_the_first_that_goes) {
  struct Case {
    std::uint64_t most;
    std::vector<std::string> left;
    std::uint64_t bytes;
  };
  const std::vector<int> sizes{5, 100, 10, 20, 30};  // the newest last
  for (const Case& of : {Case{165, {"1", "2", "3", "4", "5"}, 165}, Case{164, {"2", "3", "4", "5"}, 160},
                         Case{159, {"3", "4", "5"}, 60}, Case{60, {"3", "4", "5"}, 60}, Case{59, {"4", "5"}, 50},
                         Case{30, {"5"}, 30}, Case{29, {}, 0}, Case{0, {}, 0}}) {
    const tests::TemporaryFolder folder;
    for (std::size_t n = 0; n < sizes.size(); ++n) {
      std::ofstream(folder.file("history.00000" + std::to_string(n + 1) + ".csv"))
          << std::string(static_cast<std::size_t>(sizes[n]), 'x');
    }
    EXPECT_EQ(remove_oldest_histories(folder.file("history.csv"), of.most), of.bytes) << of.most;
    std::vector<std::string> expected;
    for (const std::string& number : of.left) expected.push_back(folder.file("history.00000" + number + ".csv"));
    EXPECT_EQ(earlier_histories(folder.file("history.csv")), expected) << of.most;
  }
}

TEST(History, counts_only_files_that_are_numbered_as_it_numbers_them) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  EXPECT_EQ(next_earlier_history(path), folder.file("history.000001.csv"));
  for (const char* other :
       {"history.csv", "history.00002.csv", "history.0000003.csv", "history.00000a.csv", "history.000000.csv",
        "histori.000004.csv", "history.000005.csw", "history.000006", "history.-00007.csv", "history_000008.csv"}) {
    folder.write(other, "1");
  }
  EXPECT_TRUE(earlier_histories(path).empty());
  EXPECT_EQ(next_earlier_history(path), folder.file("history.000001.csv"));
  for (const char* one : {"history.000019.csv", "history.000001.csv", "history.000107.csv"}) folder.write(one, "1");
  EXPECT_EQ(earlier_histories(path),
            (std::vector<std::string>{folder.file("history.000001.csv"), folder.file("history.000019.csv"),
                                      folder.file("history.000107.csv")}));
  EXPECT_EQ(next_earlier_history(path), folder.file("history.000108.csv"));
  EXPECT_EQ(next_earlier_history("no_such_history.csv"), "no_such_history.000001.csv") << "here, where it runs";
}

/// As many as the ring takes, at once.
void write_now(History& history, std::uint64_t first, std::uint64_t last) {
  Snapshot snapshot = first_snapshot(tests::small_network());
  for (snapshot.sequence = first; snapshot.sequence <= last; ++snapshot.sequence) {
    ASSERT_TRUE(history.ring().push(snapshot));
  }
  history.run(std::atomic<bool>(true));
}

/// A segment is full with the row that reaches its bytes.
TEST(History, a_file_ends_with_the_row_that_fills_it) {
  const rom::Network network = tests::small_network();
  Troubles troubles;
  const std::size_t header = history_header(network).size() + 1;
  Snapshot snapshot = first_snapshot(network);
  snapshot.sequence = 1;
  const std::size_t row = history_row(snapshot).size() + 1;
  for (const auto& [segment, rows] : {std::pair{header + 3 * row, 3}, {header + 3 * row + 1, 4}, {header + 1, 1}}) {
    for (const bool at_once : {true, false}) {
      const tests::TemporaryFolder folder;
      const std::string path = folder.file("history.csv");
      History history({path, segment, 1U << 24U}, network, troubles);
      if (at_once) {
        write_now(history, 1, 5);
      } else {
        for (std::uint64_t n = 1; n <= 5; ++n) write_now(history, n, n);
      }
      const std::string first = text_of(folder.file("history.000001.csv"));
      EXPECT_EQ(std::count(first.begin(), first.end(), '\n'), 1 + rows) << segment << " bytes";
      EXPECT_EQ(earlier_histories(path).size(), static_cast<std::size_t>(rows == 1 ? 4 : 1));
    }
  }
}

/// Of a file without rows nothing is put aside, however much of its header is there.
TEST(History, what_ends_with_the_header_is_begun_anew_and_one_row_more_is_kept) {
  const rom::Network network = tests::small_network();
  const std::string header = history_header(network) + "\n";
  for (const std::string& before :
       {std::string(), std::string("t"), header.substr(0, 10), header.substr(0, header.size() - 1), header,
        header + "0", std::string(1, '\0') + header + "1\n", header + "\n"}) {
    const tests::TemporaryFolder folder;
    const std::string path = folder.write("history.csv", before);
    Troubles troubles;
    const History history({path}, network, troubles);
    const bool has_row = before == header + "\n";
    EXPECT_EQ(earlier_histories(path).size(), has_row ? 1U : 0U) << before.size();
    EXPECT_EQ(text_of(folder.file("history.000001.csv")), has_row ? before : "");
    EXPECT_EQ(text_of(path), header);
    EXPECT_EQ(troubles.faults(), 0);
    if (!has_row) continue;  // else begun in place
    using std::filesystem::perms;
    const perms allowed = std::filesystem::status(path).permissions();
    EXPECT_EQ(allowed & (perms::owner_read | perms::owner_write), perms::owner_read | perms::owner_write);
    EXPECT_EQ(allowed & (perms::others_write | perms::others_exec | perms::sticky_bit), perms::none);
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
  const Logged log;
  Troubles troubles;
  History history({path}, tests::small_network(), troubles);
  EXPECT_NE(troubles.faults() & bits(Fault::history_lost), 0);
  EXPECT_NE(log.text().find("cannot be written: No such file or directory; rows are lost\n"), std::string::npos)
      << log.text();
  write_cycles(history, 1, 5);
  EXPECT_NE(log.text().find(path + ": 5 rows lost\n"), std::string::npos) << log.text();
  EXPECT_EQ(troubles.history_rows_lost.load(), 5U);
  std::filesystem::create_directory(folder.file("away"));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  write_cycles(history, 6, 8);
  EXPECT_EQ(troubles.faults(), 0);
  EXPECT_EQ(troubles.history_rows_lost.load(), 5U);
  EXPECT_NE(log.text().find(path + ": is written again\n"), std::string::npos) << log.text();
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

/// Each row that is lost counts once, also where a gap parts them.
TEST(History, on_a_full_disk_rows_on_either_side_of_a_gap_are_counted_and_the_last_one_too) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("history.csv");
  Troubles troubles;
  const Logged log;
  {
    History history({path}, tests::small_network(), troubles);
    write_now(history, 1, 10);
    EXPECT_EQ(log.text(), "") << "nothing is lost";
    const auto whole = std::filesystem::file_size(path);
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit full{whole + 100, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &full);
    Snapshot snapshot = first_snapshot(tests::small_network());
    for (const std::uint64_t sequence : {11U, 12U, 13U, 15U, 16U}) {
      snapshot.sequence = sequence;
      history.ring().push(snapshot);
    }
    history.run(std::atomic<bool>(true));
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, ignored);
    EXPECT_EQ(std::filesystem::file_size(path), whole);
  }
  EXPECT_EQ(troubles.history_rows_lost.load(), 5U);
  const tests::TemporaryFolder other;
  History unwritable({other.file("away/history.csv")}, tests::small_network(), troubles);
  write_now(unwritable, 1, 1);
  EXPECT_NE(log.text().find("away/history.csv: 1 rows lost\n"), std::string::npos) << log.text();
}

}  // namespace keep_history_test
}  // namespace spindle_twin::firmware

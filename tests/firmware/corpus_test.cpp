#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "tests/fuzz/check_daemon_files.hpp"
#include "tests/fuzz/check_modbus.hpp"
#include "tests/fuzz/check_plant.hpp"
#include "tests/fuzz/check_stream.hpp"

namespace spindle_twin::firmware {
namespace corpus_test {

/// Takes every file of tests/fuzz/NAME_corpus through a check, which gives why it was refused: all that the fuzzer
/// starts from, and all that it ever broke. good_* are taken, bad_* are refused.
void expect_corpus(const std::string& name,
                   const std::function<std::string(std::span<const std::uint8_t>)>& reason_of) {
  std::vector<std::filesystem::path> files;
  const std::string folder = SPINDLE_TWIN_SOURCE_DIR "/tests/fuzz/" + name + "_corpus";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 4U);
  for (const auto& file : files) {
    SCOPED_TRACE(file);
    std::ifstream stream(file, std::ios::binary);
    const std::vector<char> text{std::istreambuf_iterator<char>(stream), {}};
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    std::string reason;
    EXPECT_NO_THROW(reason = reason_of(bytes));
    EXPECT_EQ(reason.empty(), file.filename().string().starts_with("good_")) << reason;
  }
}

TEST(StreamCorpus, frames_are_taken_or_refused_and_pieces_make_no_difference) {
  expect_corpus("stream", [](std::span<const std::uint8_t> bytes) {
    const std::uint32_t refused = checked_stream(bytes).refused;
    return refused == 0 ? std::string() : std::to_string(refused) + " refused";
  });
}

TEST(RequestCorpus, each_whole_request_has_its_answer_and_writes_only_where_it_may) {
  expect_corpus("request", [](std::span<const std::uint8_t> bytes) -> std::string {
    const RequestCount count = checked_requests(bytes);
    if (count.closed) return "no Modbus/TCP";
    return count.refused == 0 ? "" : std::to_string(count.refused) + " refused";
  });
}

TEST(CheckpointCorpus, a_message_is_read_or_refused_with_a_reason) { expect_corpus("checkpoint", checked_checkpoint); }

TEST(OrdersCorpus, a_message_is_read_or_refused_with_a_reason) { expect_corpus("orders", checked_orders); }
TEST(CalibrationCorpus, a_message_is_read_or_refused_with_a_reason) {
  expect_corpus("calibration", checked_calibration);
}

TEST(ConfigCorpus, a_file_is_read_or_refused_with_a_reason) { expect_corpus("config", checked_config); }

TEST(TableCorpus, a_file_is_read_or_refused_with_a_reason) { expect_corpus("table", checked_table); }

TEST(HistoryCorpus, a_file_is_read_or_refused_with_a_reason) { expect_corpus("history", checked_history); }

TEST(CommandCorpus, a_payload_is_obeyed_or_not_with_a_reason) { expect_corpus("command", checked_command); }

}  // namespace corpus_test
}  // namespace spindle_twin::firmware

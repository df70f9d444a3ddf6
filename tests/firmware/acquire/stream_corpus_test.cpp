#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/fuzz/check_stream.hpp"

namespace spindle_twin::firmware {
namespace {

/// Everything that the fuzzer starts from, and everything that it ever broke.
TEST(StreamCorpus, frames_are_taken_or_refused_and_pieces_make_no_difference) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(SPINDLE_TWIN_SOURCE_DIR "/tests/fuzz/stream_corpus")) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 8U);
  for (const auto& file : files) {
    SCOPED_TRACE(file);
    std::ifstream stream(file, std::ios::binary);
    const std::vector<char> text{std::istreambuf_iterator<char>(stream), {}};
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    StreamCount count;
    EXPECT_NO_THROW(count = checked_stream(bytes));
    EXPECT_EQ(count.refused == 0, file.filename().string().starts_with("good_")) << count.refused;
  }
}

}  // namespace
}  // namespace spindle_twin::firmware

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "rom/file/whole_file.hpp"
#include "tests/fuzz/check_network_file.hpp"

namespace spindle_twin::rom {
namespace network_corpus_test {

/// Everything that the fuzzer starts from, and everything that it ever broke.
TEST(NetworkCorpus, every_file_is_read_or_refused_with_a_reason) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(SPINDLE_TWIN_SOURCE_DIR "/tests/fuzz/network_corpus")) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 6U);
  for (const auto& file : files) {
    SCOPED_TRACE(file);
    std::string reason;
    EXPECT_NO_THROW(reason = checked_network_file(read_whole_file(file, 1U << 20)));
    EXPECT_EQ(reason.empty(), file.filename().string().starts_with("good_")) << reason;
  }
}

}  // namespace network_corpus_test
}  // namespace spindle_twin::rom

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/fuzz/check_description.hpp"

namespace spindle_twin::fem_offline {
namespace corpus_test {

std::vector<std::filesystem::path> files_in(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(SPINDLE_TWIN_SOURCE_DIR "/" + folder)) {
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// Everything that the fuzzer starts from, and everything that it ever broke.
TEST(Corpus, every_file_ends_well_or_in_one_error_with_file_and_line) {
  const auto files = files_in("tests/fuzz/corpus");
  ASSERT_GE(files.size(), 10U);
  for (const auto& file : files) {
    SCOPED_TRACE(file);
    std::string message;
    EXPECT_NO_THROW(message = checked(text_of(file)));
    const std::string name = file.filename().string();
    if (name.starts_with("bad_")) {
      EXPECT_NE(message, "");
    }
    if (name.starts_with("good_")) {
      EXPECT_EQ(message, "");
    }
  }
}

TEST(Corpus, every_shipped_description_goes_through) {
  for (const auto& file : files_in("fem_offline/spindles")) {
    SCOPED_TRACE(file);
    EXPECT_EQ(checked(text_of(file)), "");
  }
}

/// A file cut off anywhere is an error with a line, never a crash.
TEST(Corpus, every_beginning_of_a_file_ends_well) {
  const std::string whole = text_of(SPINDLE_TWIN_SOURCE_DIR "/tests/fuzz/corpus/good_sample.toml");
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    SCOPED_TRACE(length);
    EXPECT_NO_THROW(checked(whole.substr(0, length)));
  }
}

}  // namespace corpus_test
}  // namespace spindle_twin::fem_offline

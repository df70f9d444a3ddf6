#include "host_tools/commands/offline/progress.hpp"

#include <gtest/gtest.h>

namespace spindle_twin::host_tools {
namespace {

TEST(ProgressLine, fits_every_terminal) {
  for (int columns = 1; columns < 200; ++columns) {
    for (const int percent : {0, 7, 99, 100}) {
      EXPECT_LE(progress_line("network snapshots", percent, columns).size(), static_cast<std::size_t>(columns));
    }
  }
}

TEST(ProgressLine, bar_shrinks_with_the_terminal_and_the_percent_stays) {
  EXPECT_EQ(progress_line("nodes", 50, 200),
            "nodes              [" + std::string(20, '#') + std::string(20, ' ') + "]  50 %");
  EXPECT_EQ(progress_line("nodes", 50, 37), "nodes              [#####     ]  50 %");
  EXPECT_EQ(progress_line("nodes", 50, 30), "nodes               50 %");
}

}  // namespace
}  // namespace spindle_twin::host_tools

#include "host_tools/commands/offline/progress.hpp"

#include <gtest/gtest.h>

namespace spindle_twin::host_tools {
namespace progress_test {

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

TEST(ProgressLine, shows_the_time_that_is_left) {
  EXPECT_EQ(progress_line("nodes", 50, 46, "about 40 s left"), "nodes               50 %  about 40 s left");
  EXPECT_EQ(time_left(10.0, 0.2), "about 40 s left");
  EXPECT_EQ(time_left(100.0, 0.25), "about 5 min left");
  EXPECT_EQ(time_left(1.0, 0.5), "");
  EXPECT_EQ(time_left(30.0, 1.0), "");
}

}  // namespace progress_test
}  // namespace spindle_twin::host_tools

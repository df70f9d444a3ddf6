#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host_tools/commands/offline/report/page.hpp"

namespace spindle_twin::host_tools {
namespace {

RunData some_run() {
  RunData run;
  run.spindle = "a</script>b";
  run.speed_rpm = 6000.0;
  run.time_s = {0.0, 1.0};
  const double gap = std::numeric_limits<double>::quiet_NaN();
  run.key_points = {{"inner", "degC", 27.0, {27.0, gap}, {27.0, 29.0}, {27.0, 29.1}, {27.0, 31.0}}};
  run.key_point_places_m = {{0.03, 0.2}};
  run.part_rises = {{"rotor", {0.0, 7.5}}};
  run.hottest = {"rotor", "degC", 27.0, {}, {27.0, 34.0}, {27.0, 34.5}, {27.0, 42.0}, {0.1, 0.75}};
  run.nose = {"nose", "um", 0.0, {}, {0.0, 7.0}, {0.0, 7.5}, {0.0, 15.0}};
  run.factor_names = {"all sources"};
  run.heat_factors = {{1.0, 0.46}};
  return run;
}

TEST(RunTable, errors_are_those_of_the_rise) {
  const std::string text = run_table(some_run());
  EXPECT_NE(text.find("simulated spindle"), std::string::npos);
  EXPECT_NE(text.find("+2.00          +0.10      +5.0%"), std::string::npos) << text;
  EXPECT_NE(text.find("+8.00          +0.50      +7.1%             1.50"), std::string::npos) << text;
  EXPECT_NE(text.find("+8.00          +0.50      +7.1%                -"), std::string::npos)
      << "the nose has no sigma";
}

TEST(RunPage, no_name_ends_the_data_and_gaps_are_null) {
  const std::string page = run_page(some_run());
  for (const char* part :
       {"Simulated spindle", R"("spindle":"a\u003c/script>b")", "[27.0,null]", R"("twin_sd":[0.1,0.75])"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(page.find("a</script>b"), std::string::npos);
}

TEST(RunPage, nothing_is_loaded) {
  const std::string page = run_page(some_run());
  for (const char* part : {" src=\"", " href=\"", "@import"}) {
    EXPECT_EQ(page.find(part), std::string::npos) << part;
  }
}

}  // namespace
}  // namespace spindle_twin::host_tools

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "host_tools/commands/offline/report/page.hpp"

namespace spindle_twin::host_tools {
namespace report_test {

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

/// The numbers of the row whose name begins so, the last column as text.
std::vector<std::string> row_of(const std::string& table, const std::string& name) {
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(name, 0) != 0) continue;
    std::istringstream cells(line.substr(24));
    return {std::istream_iterator<std::string>(cells), {}};
  }
  return {};
}

TEST(RunTable, rises_and_errors_count_from_the_reference_and_are_those_of_the_last_instant) {
  const std::string text = run_table(some_run());
  EXPECT_EQ(text.rfind("simulated spindle 'a</script>b' after 1 s at 6000 rpm, ambient 0.0 degC: rises\n", 0), 0U)
      << text;
  using Cells = std::vector<std::string>;
  // unit, uncorrected, twin, plant, error uncorrected and of the twin, its share of the plant's rise, 2 sigma
  EXPECT_EQ(row_of(text, "key point inner"), (Cells{"K", "4.00", "2.10", "2.00", "+2.00", "+0.10", "+5.0%", "-"}));
  EXPECT_EQ(row_of(text, "rotor, maximum"), (Cells{"K", "15.00", "7.50", "7.00", "+8.00", "+0.50", "+7.1%", "1.50"}));
  EXPECT_EQ(row_of(text, "nose, elongation"), (Cells{"um", "15.00", "7.50", "7.00", "+8.00", "+0.50", "+7.1%", "-"}))
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

}  // namespace report_test
}  // namespace spindle_twin::host_tools

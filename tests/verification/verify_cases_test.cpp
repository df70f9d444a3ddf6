// The suite of cases with known answers, and that it can fail.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "fem_offline/verify_cases/fem_case.hpp"

namespace spindle_twin::fem_offline {
namespace verify_cases_test {

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// A copy of a case with one text replaced, in a folder of its own.
std::string changed_case(const std::string& id, const std::string& from, const std::string& to) {
  std::string text = text_of(default_cases_directory() + "/" + id + ".toml");
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error(from + " is not in " + id);
  text.replace(at, from.size(), to);
  const auto folder =
      std::filesystem::temp_directory_path() / ("verify_case_" + std::to_string(std::hash<std::string>{}(from + to)));
  std::filesystem::create_directories(folder);
  const auto path = folder / (id + ".toml");
  std::ofstream(path) << text;
  return path.string();
}

class VerifyCase : public testing::TestWithParam<std::string> {};

TEST_P(VerifyCase, is_within_its_tolerances) {
  const CaseResult result = run_case(GetParam(), 1.0);
  for (const CheckedFigure& figure : result.figures) {
    EXPECT_TRUE(figure.passed) << result.id << ", " << figure.figure << ": " << figure.result << " " << figure.unit
                               << " instead of " << figure.target << ", error " << figure.error << " of "
                               << figure.tolerance;
  }
}

INSTANTIATE_TEST_SUITE_P(Suite, VerifyCase, testing::ValuesIn(case_files(default_cases_directory())),
                         [](const auto& tested) { return std::filesystem::path(tested.param).stem().string(); });

TEST(VerifyCases, quadratic_elements_converge_at_their_orders) {
  const std::vector<CaseResult> orders = run_orders(default_cases_directory());
  EXPECT_EQ(orders.size(), 4U);
  for (const CaseResult& result : orders) {
    for (const CheckedFigure& figure : result.figures) {
      EXPECT_TRUE(figure.passed) << result.id << ", " << figure.figure << ": " << figure.result;
    }
  }
}

TEST(VerifyCases, a_wrong_conductivity_fails) {
  const CaseResult result =
      run_case(changed_case("shaft_in_sleeve", "conductivity_r_W_per_mK = 48", "conductivity_r_W_per_mK = 48.5"), 1.0);
  EXPECT_FALSE(result.figures[0].passed);  // the centre
  EXPECT_TRUE(result.figures[3].passed);   // the outside, where only heat and film count
}

TEST(VerifyCases, an_expectation_of_nothing_is_an_error_with_file_and_line) {
  try {
    run_case(changed_case("shaft_in_sleeve", "of = \"centre\"", "of = \"center\""), 1.0);
    FAIL() << "accepted";
  } catch (const rom::InputError& error) {
    EXPECT_TRUE(std::regex_search(error.what(), std::regex("shaft_in_sleeve.toml:[0-9]+: expect")));
    EXPECT_NE(std::string(error.what()).find("center"), std::string::npos);
  }
}

/// 1e-6 of the span is what is promised, and the coefficient is no worse for a mesh sixteen times finer.
TEST(PrescribedTemperature, holds_to_1e_6_of_the_span_on_any_mesh) {
  for (const double mesh_factor : {8.0, 1.0, 0.5}) {
    const CaseResult result = run_case(default_cases_directory() + "/radiation_and_film.toml", mesh_factor);
    EXPECT_LT(std::abs(result.figures[0].error), 1e-6) << mesh_factor;
  }
}

}  // namespace verify_cases_test
}  // namespace spindle_twin::fem_offline

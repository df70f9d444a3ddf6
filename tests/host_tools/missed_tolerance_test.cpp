#include "host_tools/commands/offline/missed_tolerance.hpp"

#include <gtest/gtest.h>

#include "host_tools/commands/offline/accuracy_options.hpp"

namespace spindle_twin::host_tools {
namespace missed_tolerance_test {

using fem_offline::MissedOutput;

ToleranceVerdict end_winding_missed() {
  ToleranceVerdict verdict;
  verdict.missed = {{MissedOutput::Kind::part_maximum, "end_winding_front", 0.295, 0.12},
                    {MissedOutput::Kind::deformation, "nose", 0.0101, 0.009}};
  verdict.nodes = 320;
  verdict.larger_possible = true;
  return verdict;
}

TEST(MissedTolerance, names_the_outputs_and_what_would_help) {
  const std::string text = tolerance_text(end_winding_missed(), "whole");
  for (const char* said : {"0.03K,0.015um,0.2K", "maximum of end_winding_front", "0.295 K", "0.12 K",
                           "deformation nose", "0.0101 um", "--nodes 365", "--box small", "which 320 nodes keep"}) {
    EXPECT_NE(text.find(said), std::string::npos) << said << " in\n" << text;
  }
}

TEST(MissedTolerance, what_is_offered_can_be_had) {
  ToleranceVerdict none_larger = end_winding_missed(), too_many = none_larger;
  none_larger.larger_possible = false;
  too_many.nodes = most_nodes;
  for (const ToleranceVerdict& verdict : {none_larger, too_many}) {
    const std::string text = tolerance_text(verdict, "small");
    EXPECT_EQ(text.find("--nodes"), std::string::npos) << text;
    EXPECT_EQ(text.find("--box"), std::string::npos) << text;
  }
}

TEST(MissedTolerance, the_tolerance_offered_is_kept_by_this_network_and_readable) {
  const fem_offline::Tolerance offered = parse_tolerance(kept_tolerance(end_winding_missed()));
  EXPECT_EQ(offered.key_points_K, 0.03);  // was kept
  EXPECT_GE(offered.deformations_um * fem_offline::share_of_tolerance, 0.0101);
  EXPECT_GE(offered.part_max_K * fem_offline::share_of_tolerance, 0.295);
  EXPECT_LT(offered.part_max_K * fem_offline::share_of_tolerance, 0.31);
}

TEST(MissedTolerance, as_json_says_which_output_and_how_much) {
  const nlohmann::ordered_json json = tolerance_json(end_winding_missed());
  EXPECT_EQ(json.at("kept"), false);
  EXPECT_EQ(json.at("missed").at(1).at("output"), "deformation nose");
  EXPECT_EQ(json.at("missed").at(1).at("unit"), "um");
  EXPECT_EQ(tolerance_json({}).dump(), R"({"kept":true,"judged_by":"search","margin_kept":false})");
}

TEST(MissedTolerance, limits_of_a_certificate_outweigh_the_margin_of_the_search) {
  fem_offline::AffineModel model;
  model.parts.resize(2);
  model.parts[1].name = "end_winding_front";
  fem_offline::SizeChoice choice;
  choice.missed = end_winding_missed().missed;
  rom::Certificate certificate;
  EXPECT_FALSE(judge_tolerance(choice, model, certificate, {}).kept());  // no limits: the search decides
  certificate.cases = 33;
  certificate.limit_rule = {0.95, 0.95, true};
  certificate.part_maxima_K.resize(2);
  certificate.part_maxima_K[1].limit = 0.19;
  certificate.limit.part_max_K = 0.193;
  const ToleranceVerdict kept = judge_tolerance(choice, model, certificate, {});
  EXPECT_TRUE(kept.kept());
  EXPECT_NE(tolerance_text(kept, "whole").find("(33 cases) keep the tolerance"), std::string::npos);
  certificate.limit.part_max_K = 0.21;
  choice.reached = true;
  const ToleranceVerdict missed = judge_tolerance(choice, model, certificate, {});
  ASSERT_EQ(missed.missed.size(), 1U);
  EXPECT_EQ(missed.missed[0].name, "end_winding_front");
  EXPECT_EQ(kept_tolerance(missed), "0.03K,0.015um,0.21K");
}

}  // namespace missed_tolerance_test
}  // namespace spindle_twin::host_tools

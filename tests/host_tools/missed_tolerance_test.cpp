#include "host_tools/commands/offline/missed_tolerance.hpp"

#include <gtest/gtest.h>

#include "host_tools/commands/offline/accuracy_options.hpp"

namespace spindle_twin::host_tools {
namespace missed_tolerance_test {

using fem_offline::MissedOutput;

fem_offline::SizeChoice end_winding_missed() {
  fem_offline::SizeChoice choice;
  choice.missed = {{MissedOutput::Kind::part_maximum, "end_winding_front", 0.295, 0.12},
                   {MissedOutput::Kind::deformation, "nose", 0.0101, 0.009}};
  choice.nodes_likely_enough = 365;
  choice.network.nodes.resize(320);
  return choice;
}

TEST(MissedTolerance, names_the_outputs_and_what_would_help) {
  const std::string text = missed_tolerance_text(end_winding_missed(), {0.03, 0.015, 0.2}, "whole");
  for (const char* said : {"0.03K,0.015um,0.2K", "maximum of end_winding_front", "0.295 K", "0.12 K",
                           "deformation nose", "0.0101 um", "--nodes 365", "--box small", "which 320 nodes keep"}) {
    EXPECT_NE(text.find(said), std::string::npos) << said << " in\n" << text;
  }
}

TEST(MissedTolerance, what_is_offered_can_be_had) {
  fem_offline::SizeChoice choice = end_winding_missed();
  for (const int nodes : {0, most_nodes + 1}) {
    choice.nodes_likely_enough = nodes;
    const std::string text = missed_tolerance_text(choice, {0.03, 0.015, 0.2}, "small");
    EXPECT_EQ(text.find("--nodes"), std::string::npos) << text;
    EXPECT_EQ(text.find("--box"), std::string::npos) << text;
  }
}

TEST(MissedTolerance, the_tolerance_offered_is_kept_by_this_network_and_readable) {
  const fem_offline::SizeChoice choice = end_winding_missed();
  const fem_offline::Tolerance offered = parse_tolerance(kept_tolerance(choice, {0.03, 0.015, 0.2}));
  EXPECT_EQ(offered.key_points_K, 0.03);  // was kept
  EXPECT_GE(offered.deformations_um * fem_offline::share_of_tolerance, 0.0101);
  EXPECT_GE(offered.part_max_K * fem_offline::share_of_tolerance, 0.295);
  EXPECT_LT(offered.part_max_K * fem_offline::share_of_tolerance, 0.31);
}

TEST(MissedTolerance, as_json_says_which_output_and_how_much) {
  const nlohmann::ordered_json json = missed_tolerance_json(end_winding_missed());
  EXPECT_EQ(json.at("kept"), false);
  EXPECT_EQ(json.at("missed").at(1).at("output"), "deformation nose");
  EXPECT_EQ(json.at("missed").at(1).at("unit"), "um");
  fem_offline::SizeChoice kept;
  kept.reached = true;
  EXPECT_EQ(missed_tolerance_json(kept).dump(), R"({"kept":true})");
}

}  // namespace missed_tolerance_test
}  // namespace spindle_twin::host_tools

#include "firmware/show/scene_json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace show_scene_json_test {

TEST(SceneJson, holds_outlines_and_key_points_at_their_places_and_the_notice_and_whether_there_is_a_history) {
  rom::Network network = tests::small_network();
  network.outlines = {{"rotor", (Eigen::MatrixXd(2, 3) << 0.01, 0.03, 0.03, 0.0, 0.0, 0.125).finished()},
                      {"sleeve \"rear\"", Eigen::MatrixXd::Zero(2, 0)}};
  const nlohmann::json scene =
      nlohmann::json::parse(scene_json(network, {"a <b>simulated</b> \"spindle\"", true, "", {}}));
  EXPECT_EQ(scene.at("notice"), "a <b>simulated</b> \"spindle\"");
  EXPECT_EQ(scene.at("has_history"), true);
  ASSERT_EQ(scene.at("outlines").size(), 2U);
  EXPECT_EQ(scene["outlines"][0]["part"], "rotor");
  EXPECT_EQ(scene["outlines"][0]["points_m"], nlohmann::json({{0.01, 0.0}, {0.03, 0.0}, {0.03, 0.125}}));
  EXPECT_EQ(scene["outlines"][1]["part"], "sleeve \"rear\"");
  EXPECT_TRUE(scene["outlines"][1]["points_m"].empty());
  ASSERT_EQ(scene.at("key_points").size(), network.key_points.size());
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    EXPECT_EQ(scene["key_points"][k]["name"], network.key_points[k].name);
    EXPECT_EQ(scene["key_points"][k]["at_m"], nlohmann::json({network.key_points[k].r_m, network.key_points[k].z_m}));
  }
}

TEST(SceneJson, names_the_heat_flows_and_the_bodies_between_which_they_go) {
  const rom::Network network = tests::small_network();
  const nlohmann::json scene = nlohmann::json::parse(scene_json(network, {}));
  ASSERT_EQ(scene.at("bodies").size(), 3U);
  EXPECT_EQ(scene["bodies"][2].at("name"), "sleeve");
  EXPECT_NEAR(scene["bodies"][2].at("centre_m")[0].get<double>(), 0.044, 1e-12);
  EXPECT_NEAR(scene["bodies"][2].at("centre_m")[1].get<double>(), 0.36, 1e-12);
  ASSERT_EQ(scene.at("flows").size(), 4U);
  const nlohmann::json& joint = scene["flows"][0];
  EXPECT_EQ(joint.at("name"), "rotor_bearing");
  EXPECT_EQ(joint.at("kind"), "contact");
  EXPECT_EQ(joint.at("from"), "rotor");
  EXPECT_EQ(joint.at("to"), "bearing");
  EXPECT_EQ(joint.at("outside"), false);
  EXPECT_EQ(joint.at("at_m").size(), 2U);
  EXPECT_EQ(scene["flows"][2].at("from"), "sleeve");
  EXPECT_EQ(scene["flows"][2].at("to"), "coolant");
  EXPECT_EQ(scene["flows"][2].at("outside"), true);
}

TEST(SceneJson, of_a_network_without_outlines_is_whole_too) {
  const nlohmann::json scene = nlohmann::json::parse(scene_json(tests::small_network(), {}));
  EXPECT_EQ(scene.at("notice"), "");
  EXPECT_EQ(scene.at("has_history"), false);
  EXPECT_TRUE(scene.at("outlines").is_array());
}

TEST(SceneJson, says_which_network_and_how_the_compensation_is_configured) {
  CompensationPlan plan;
  plan.sign = -1.0;
  plan.step_m = 0.25e-6;
  const rom::Network network = tests::small_network();
  nlohmann::json scene = nlohmann::json::parse(scene_json(network, {"", false, "abc", plan}));
  EXPECT_EQ(scene["network"]["sha256"], "abc");
  EXPECT_EQ(scene["network"]["cases"], 20);
  EXPECT_EQ(scene["network"]["worst_nose_um"], network.certificate.worst.nose_um);
  EXPECT_EQ(scene["compensation"]["sign"], -1);
  EXPECT_TRUE(scene["compensation"]["limit_um"].is_null());
  EXPECT_DOUBLE_EQ(scene["compensation"]["slew_um_per_s"], 0.5);
  EXPECT_DOUBLE_EQ(scene["compensation"]["step_um"], 0.25);
  plan.limit_m = 5e-6;
  scene = nlohmann::json::parse(scene_json(network, {"", false, "", plan}));
  EXPECT_DOUBLE_EQ(scene["compensation"]["limit_um"], 5.0);
}

}  // namespace show_scene_json_test
}  // namespace spindle_twin::firmware

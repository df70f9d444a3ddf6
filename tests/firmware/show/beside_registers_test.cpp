#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "firmware/serve/fill_image.hpp"
#include "firmware/show/factor_json.hpp"
#include "firmware/show/flow_json.hpp"
#include "firmware/show/state_json.hpp"
#include "tests/firmware/support/machine.hpp"

namespace spindle_twin::firmware {
namespace show_beside_registers_test {

nlohmann::json parsed(const std::string& members) { return nlohmann::json::parse("{" + members + "}"); }

TEST(BesideRegisters, factors_have_their_priors_and_deviations_by_name_and_null_where_there_is_none) {
  const rom::Network network = tests::small_network();
  const ShownNames names = names_of(network);
  for (const bool has_estimator : {true, false}) {
    Cycle cycle(network, has_estimator ? estimated() : corrected(), runtime);
    const Machine machine(network, 1.0);
    const Snapshot& last = cycle.step(machine.frame(at_s(0)), {}, at_s(0), 0);
    const nlohmann::json factors = parsed(factors_json(last, names)).at("factors");
    ASSERT_EQ(factors.at("heat").size(), names.sources.size());
    ASSERT_EQ(factors.at("conductance").size(), names.conductances.size());
    const nlohmann::json& contact = factors["conductance"].at("bearing_sleeve");
    for (const char* key : {"prior_ln_mean", "prior_ln_sd", "ln_sd"}) {
      EXPECT_EQ(contact.at(key).is_null(), !has_estimator) << key;
    }
    if (!has_estimator) continue;
    EXPECT_NEAR(contact["prior_ln_sd"].get<double>(), 0.6, 1e-4);
    EXPECT_NEAR(contact["prior_ln_mean"].get<double>(), -0.18, 1e-4);
    EXPECT_NEAR(contact["ln_sd"].get<double>(), 0.6, 0.01) << "no reading has told of it yet";
  }
}

TEST(BesideRegisters, while_the_correction_is_off_only_the_prior_is_told) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.correction_enabled = false;
  Cycle cycle(network, plan, runtime);
  const Machine machine(network, 1.0);
  const Snapshot& last = cycle.step(machine.frame(at_s(0)), {}, at_s(0), 0);
  EXPECT_TRUE(std::isnan(last.heat_band[0].deviation));
  EXPECT_GT(last.heat_band[0].prior_deviation, 0.4F);
}

TEST(BesideRegisters, heat_flows_are_a_list_in_the_order_of_the_scene_and_empty_before_the_first_prediction) {
  Snapshot snapshot;
  EXPECT_TRUE(parsed(flows_json(snapshot)).at("heat").at("flow_W").empty());
  snapshot.flows = snapshot.bodies = 2;
  snapshot.flow_W[0] = -12.3456;
  snapshot.made_W[1] = 60.0;
  const nlohmann::json heat = parsed(flows_json(snapshot)).at("heat");
  EXPECT_EQ(heat.at("flow_W"), nlohmann::json({-12.346, nullptr}));
  EXPECT_EQ(heat.at("made_W"), nlohmann::json({nullptr, 60.0}));
}

TEST(BesideRegisters, they_are_members_of_the_state) {
  RegisterImage image{};
  Snapshot snapshot;
  fill_image(snapshot, 0, image);
  const ShownNames names = names_of(tests::small_network());
  const nlohmann::json state =
      nlohmann::json::parse(state_json(image, names, factors_json(snapshot, names) + "," + flows_json(snapshot)));
  for (const char* key : {"spindle", "registers", "factors", "heat"}) EXPECT_TRUE(state.contains(key)) << key;
}

}  // namespace show_beside_registers_test
}  // namespace spindle_twin::firmware

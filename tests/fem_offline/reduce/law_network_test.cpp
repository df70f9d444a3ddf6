#include <gtest/gtest.h>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/verify.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/network_operator.hpp"
#include "rom/integrate/outputs.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_law_network_test {

/// The reference spindle with physical laws, on a coarse mesh.
const AffineModel& model() {
  static const FeModel built = [] {
    Spindle spindle = read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference_laws.toml");
    spindle.mesh.element_size_m = 0.012;
    return FeModel(spindle, build_section(spindle));
  }();
  return built.affine();
}

const rom::Network& law_network() {
  static const rom::Network built = [] {
    ReduceOptions options;
    options.nodes = 120;
    options.full_sets = 30;
    options.full_histories = 30;
    options.rich_sets = 60;
    options.rich_states = 260;
    return reduce_model(model(), options);
  }();
  return built;
}

rom::BoundaryValues values_at(const rom::OperatingState& state) {
  const rom::Boundaries& boundaries = law_network().boundaries;
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, state, rom::no_correction(boundaries), values);
  return values;
}

/// What the network comes to while its laws follow its temperatures, with the heats that they then give.
struct Followed {
  explicit Followed(const rom::OperatingState& state) : values(values_at(state)) {
    const auto shared = std::make_shared<const rom::NetworkOperator>(law_network());
    const Eigen::VectorXd nodes_K = rom::steady_temperatures_K(shared, values);
    outputs = rom::make_network_outputs(law_network());
    rom::evaluate_outputs(law_network(), nodes_K, outputs);
    shared->laws().at_temperatures(nodes_K, values);
  }
  rom::BoundaryValues values;
  rom::NetworkOutputs outputs;
};

TEST(LawNetwork, steady_state_with_laws_that_follow_is_the_fe_models_with_laws_held_at_their_nominal_inputs) {
  const rom::BoundaryValues held = values_at(law_network().boundaries.operating);
  const Eigen::VectorXd full_K = solve_steady(model(), held);
  const HeatBalance balance = steady_heat_balance(model(), held, full_K);
  EXPECT_NEAR(balance.heat_out_W, balance.heat_in_W, 1e-9 * balance.heat_in_W);
  const Followed followed(law_network().boundaries.operating);
  EXPECT_NEAR(followed.values.heat_W.sum(), balance.heat_in_W, 0.01 * balance.heat_in_W);
  for (std::size_t p = 0; p < model().parts.size(); ++p) {
    EXPECT_NEAR(followed.outputs.part_mean_K[static_cast<Eigen::Index>(p)], model().parts[p].mean_row.dot(full_K), 0.15)
        << law_network().parts[p].name;
  }
  const Eigen::VectorXd rise_K = full_K.array() - law_network().boundaries.reference_temperature_K;
  EXPECT_NEAR(1e6 * followed.outputs.deformations_m[0], 1e6 * model().deformations[0].row_m_per_K.dot(rise_K), 0.15);
}

TEST(LawNetwork, nominal_inputs_in_the_description_are_those_of_its_steady_state) {
  const Followed followed(law_network().boundaries.operating);
  const rom::Boundaries& boundaries = law_network().boundaries;
  const auto check = [&](const std::string& name, const rom::BoundLaw& law) {
    for (const rom::LawTemperature& read : {law.first, law.second}) {
      if (read.part < 0) continue;
      EXPECT_NEAR(followed.outputs.part_mean_K[read.part], read.nominal_K, 0.3) << name;
    }
    if (law.pressure >= 0) {
      EXPECT_NEAR(followed.outputs.contact_pressures_Pa[law.pressure] / law.nominal_pressure_Pa, 1.0, 0.05) << name;
    }
    if (law.displacement >= 0) {
      EXPECT_NEAR(followed.outputs.deformations_m[law.displacement], law.nominal_displacement_m, 5e-8) << name;
    }
  };
  int laws = 0;
  for (const rom::HeatSource& source : boundaries.sources) {
    if (source.physics) check(source.name, *source.physics), ++laws;
  }
  for (const rom::Conductance& item : boundaries.conductances) {
    if (item.physics) check(item.name, *item.physics), ++laws;
  }
  EXPECT_EQ(laws, 6 + 6 + 4 + 8 + 4 + 1) << "heats, fits, ball paths, coolant, films, air gap";
}

TEST(LawNetwork, heats_and_fits_follow_away_from_the_operating_state) {
  const rom::Boundaries& boundaries = law_network().boundaries;
  rom::OperatingState overloaded = boundaries.operating;
  overloaded.load = 2.0;
  const rom::BoundaryValues held = values_at(overloaded);
  const Followed followed(overloaded);
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double share = followed.values.heat_W[row] / held.heat_W[row];
    if (boundaries.sources[i].name == "front_bearings") {
      EXPECT_GT(share, 1.03) << "the rings press the balls harder, more than thinner oil saves";
    }
    if (boundaries.sources[i].name == "copper") {
      EXPECT_GT(share, 1.05) << "a warm winding resists more";
    }
  }
  int fits = 0;
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const auto& physics = boundaries.conductances[j].physics;
    if (!physics || physics->pressure < 0) continue;
    const auto row = static_cast<Eigen::Index>(j);
    rom::LawState state = rom::nominal_state(*physics, followed.values.laws, followed.values.environment_K);
    state[rom::LawInput::pressure_Pa] = followed.outputs.contact_pressures_Pa[physics->pressure];
    const double by_law = rom::evaluate(physics->law, state).value;
    EXPECT_NEAR(followed.values.conductance_W_per_m2K[row], by_law, 1e-9 * by_law);
    if (std::abs(followed.values.conductance_W_per_m2K[row] / held.conductance_W_per_m2K[row] - 1.0) > 0.03) ++fits;
  }
  EXPECT_GE(fits, 4) << "conductances of fits change with the pressure that the heat makes";
}

TEST(LawNetwork, follows_the_fe_model_through_random_drive_cycles) {
  VerifyOptions options;
  options.cases = 2;
  options.seed = 5;
  options.drive.box = {
      .contact_low = 0.5, .contact_high = 2.0, .film_low = 0.7, .film_high = 1.4, .speed_high_rpm = 9000.0};
  const rom::Certificate certificate = verify_network(law_network(), model(), options).certificate;
  EXPECT_LT(certificate.worst.key_points_K, 0.1);
  EXPECT_LT(certificate.worst.nose_um, 0.1);
}

}  // namespace reduce_law_network_test
}  // namespace spindle_twin::fem_offline

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "correction/paper/paper_correction.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/integrate/cvode_stepper.hpp"

/// The ratio law on a network whose heats, joints and films follow physical laws: superposition holds only for what the
/// two solutions share, so the base must have the other heats and all conductances of the corrected network.
namespace spindle_twin::correction::test {
namespace paper_law_base_test {

constexpr double law_period_s = 80.0;

struct Twin {
  Twin() : shared(std::make_shared<const rom::NetworkOperator>(network)), stepper(shared) {
    values = rom::make_boundary_values(network.boundaries);
    stepper.set_temperatures(Eigen::VectorXd::Constant(static_cast<Eigen::Index>(network.nodes.size()),
                                                       network.boundaries.reference_temperature_K));
  }

  Eigen::Index source(const std::string& name) const {
    for (std::size_t i = 0; i < network.boundaries.sources.size(); ++i) {
      if (network.boundaries.sources[i].name == name) return static_cast<Eigen::Index>(i);
    }
    throw std::logic_error(name);
  }
  void advance(const rom::OperatingState& state, const rom::CorrectionFactors& factors, double advance_s) {
    rom::evaluate_boundaries(network.boundaries, state, factors, values);
    ASSERT_EQ(stepper.advance(advance_s, values), rom::StepStatus::ok);
  }
  Eigen::VectorXd key_points_K() const {
    Eigen::VectorXd result(static_cast<Eigen::Index>(network.key_points.size()));
    for (Eigen::Index k = 0; k < result.size(); ++k) {
      result[k] = network.key_points[static_cast<std::size_t>(k)].row.dot(stepper.temperatures_K());
    }
    return result;
  }

  rom::Network network = rom::read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle_laws.toml");
  std::shared_ptr<const rom::NetworkOperator> shared;
  rom::CvodeStepper stepper;
  rom::BoundaryValues values;
};

PaperOptions of_copper(const Twin& twin) {
  PaperOptions options;
  options.window_s = 0.0;
  options.joint_law = false;
  options.groups = common_heat_group(twin.network);
  options.groups[0].sources = {static_cast<int>(twin.source("copper"))};
  options.guards.minimum_rise_K = 1e-3;
  options.guards.reading_uncertainty_K = 1e-6;
  return options;
}

PaperCorrection correction_of(const Twin& twin, const PaperOptions& options) {
  return {twin.network, options, [&] { return std::make_unique<rom::CvodeStepper>(twin.shared); }};
}

TEST(LawBase, rise_over_the_base_is_what_the_groups_own_heat_has_done) {
  Twin twin;
  const Eigen::Index copper = twin.source("copper");
  PaperCorrection law = correction_of(twin, of_copper(twin));
  const rom::CorrectionFactors described = rom::no_correction(twin.network.boundaries);
  // The same equations with no other heat, in surroundings at the datum: C dr/dt = -K(t) r + B q_copper(t).
  Twin own;
  // And what a base of its own temperatures would be.
  Twin colder;
  rom::CorrectionFactors without_copper = described;
  without_copper.heat[copper] = 0.0;
  const double datum_K = twin.network.boundaries.reference_temperature_K;
  const Eigen::Array<bool, Eigen::Dynamic, 1> valid =
      Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(static_cast<Eigen::Index>(twin.network.key_points.size()), true);
  double furthest = 0.0;
  for (int n = 0; n <= 3600; ++n) {
    rom::OperatingState state = twin.network.boundaries.operating;
    state.load = 2.0;
    if (n >= 1600) state.speed_rpm *= 1.5;
    const Eigen::VectorXd seen_K = twin.key_points_K();
    const Eigen::VectorXd nodes_K = twin.stepper.temperatures_K();
    law.step({static_cast<double>(n), seen_K, valid, seen_K, nodes_K, state}, 1.0);
    ASSERT_EQ(law.factors().heat[copper], 1.0) << "prediction and reading agree";
    if (n > 0 && n % static_cast<int>(law_period_s) == 0 && law.freeze(0) == Freeze::deadband) {
      const double own_K = own.key_points_K().mean() - datum_K;
      EXPECT_NEAR(law.base_rise_K(0), own_K, 2e-4 * own_K) << n << " s";
      furthest = std::max(furthest, std::abs(seen_K.mean() - colder.key_points_K().mean() - own_K) / own_K);
    }
    twin.advance(state, described, 1.0);
    colder.advance(state, without_copper, 1.0);
    rom::evaluate_boundaries(own.network.boundaries, state, described, own.values);
    own.shared->laws().at_temperatures(0.5 * (nodes_K + twin.stepper.temperatures_K()), own.values);
    own.values.laws.follow = false;
    const double copper_W = own.values.heat_W[copper];
    own.values.heat_W.setZero();
    own.values.heat_W[copper] = copper_W;
    own.values.environment_K.setConstant(datum_K);
    ASSERT_EQ(own.stepper.advance(1.0, own.values), rom::StepStatus::ok);
  }
  EXPECT_GT(furthest, 2e-3) << "a base that followed its own temperatures would be wrong by this share of the rise";
}

TEST(LawBase, factor_comes_to_that_of_the_machine_though_the_heat_follows_its_temperature) {
  for (const bool rescale : {true, false}) {
    Twin twin, machine;
    const Eigen::Index copper = twin.source("copper");
    PaperOptions options = of_copper(twin);
    options.state_rescale = rescale;
    if (!rescale) options.relaxation = 0.1;
    PaperCorrection law = correction_of(twin, options);
    rom::CorrectionFactors truth = rom::no_correction(machine.network.boundaries);
    truth.heat[copper] = 0.6;
    rom::OperatingState state = twin.network.boundaries.operating;
    state.load = 2.0;
    const Eigen::Array<bool, Eigen::Dynamic, 1> valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(
        static_cast<Eigen::Index>(twin.network.key_points.size()), true);
    for (int n = 0; n < (rescale ? 3600 : 14400); ++n) {
      const PaperStep step = law.step({static_cast<double>(n), machine.key_points_K(), valid, twin.key_points_K(),
                                       twin.stepper.temperatures_K(), state},
                                      1.0);
      if (step.state_rescaled) twin.stepper.set_temperatures(law.rescaled_nodes_K());
      twin.advance(state, law.factors(), 1.0);
      machine.advance(state, truth, 1.0);
    }
    EXPECT_NEAR(law.factors().heat[copper], 0.6, 0.003) << (rescale ? "state corrected" : "state kept");
    EXPECT_LT((twin.key_points_K() - machine.key_points_K()).cwiseAbs().maxCoeff(), 0.02);
    EXPECT_GT(machine.key_points_K().mean() - machine.network.boundaries.reference_temperature_K, 5.0);
  }
}

}  // namespace paper_law_base_test
}  // namespace spindle_twin::correction::test

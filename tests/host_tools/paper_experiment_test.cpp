#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "correction/estimator/estimator_correction.hpp"
#include "correction/paper/paper_correction.hpp"
#include "fem_offline/mesh/section.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/reduce.hpp"
#include "firmware/config/config.hpp"
#include "firmware/cycle/cycle.hpp"
#include "host_tools/virtual_spindle/plant_truth.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/units.hpp"
#include "tests/support/no_guards.hpp"

/// The demo's experiment without clocks and sockets, over several sets of joints: 6000 rpm, 1800 s, true heat 0.46 of
/// the described, joints off by up to 2x, noise 0.03 K, offsets 0.02 K. Prints the numbers of correction/README.md.
namespace spindle_twin::host_tools {
namespace paper_experiment_test {

constexpr int duration_s = 1800;
constexpr int joint_sets = 4;
constexpr int settled_s = 300;

struct Truth {
  std::vector<PlantSnapshot> seconds;
};

/// Worst over the joint sets.
struct Score {
  double key_point_end_K = 0.0;      ///< at the end
  double key_point_settled_K = 0.0;  ///< from 300 s on
  double key_point_late_K = 0.0;     ///< from half of the experiment on
  double nose_share = 0.0;           ///< error of the nose at the end over that of the uncorrected model
};

class PaperExperiment : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    fem_offline::Spindle spindle =
        fem_offline::read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference.toml");
    const fem_offline::Section section = fem_offline::build_section(spindle);
    fem_offline::ReduceOptions reduce;
    reduce.nodes = 110;
    reduce.full_sets = 16;
    reduce.full_histories = 16;
    reduce.rich_states = 240;
    reduce.rich_sets = 40;
    network = new rom::Network(fem_offline::reduce_model(fem_offline::FeModel(spindle, section).affine(), reduce));
    spindle.mesh.element_size_m = 0.010;  // another mesh than the twin's
    const fem_offline::FeModel fe(spindle, section);
    for (int seed = 1; seed <= joint_sets; ++seed) truths.push_back(run_plant(fe.affine(), seed));
    truths_nominal_nose_um = 1e6 * run_twin(truths.front(), nullptr).back();
  }
  static void TearDownTestSuite() { delete network; }

  static Truth run_plant(const fem_offline::AffineModel& model, int seed) {
    HiddenTruth hidden;
    hidden.heat_factors = {{"all", 0.46}};
    hidden.contact_spread = ContactSpread{static_cast<std::uint64_t>(seed), 2.0};
    hidden.noise_K = 0.03;
    hidden.seed = static_cast<std::uint64_t>(seed);
    hidden.offsets_K = {{"inner", 0.02}, {"outer", -0.02}};
    Plant plant(model, hidden, rom::constant_schedule(model.boundaries, 1.0));
    Truth truth;
    for (int second = 0; second <= duration_s; ++second) {
      truth.seconds.push_back(plant.snapshot());
      plant.advance(1.0);
    }
    return truth;
  }

  /// Key points of every second, then the nose in m as the last value; without options: uncorrected.
  static std::vector<double> run_twin(const Truth& truth, const correction::PaperOptions* options) {
    const auto stepper = rom::make_runtime_stepper(*network);
    correction::PaperCorrection law(*network, options != nullptr ? *options : correction::PaperOptions{},
                                    [] { return rom::make_runtime_stepper(*network); });
    rom::NetworkOutputs outputs = rom::make_network_outputs(*network);
    rom::BoundaryValues values = rom::make_boundary_values(network->boundaries);
    const rom::CorrectionFactors none = rom::no_correction(network->boundaries);
    const auto key_points = static_cast<Eigen::Index>(network->key_points.size());
    const auto valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(key_points, true).eval();
    Eigen::VectorXd measured_K(key_points);
    std::vector<double> result;
    for (int second = 0; second <= duration_s; ++second) {
      rom::evaluate_outputs(*network, stepper->temperatures_K(), outputs);
      for (Eigen::Index k = 0; k < key_points; ++k) {
        result.push_back(outputs.key_points_K[k] - rom::zero_degC_K);
        measured_K[k] = rom::zero_degC_K +
                        truth.seconds[static_cast<std::size_t>(second)].measured_degC[static_cast<std::size_t>(k)];
      }
      if (second == duration_s) break;
      if (options != nullptr) {
        const correction::PaperStep step =
            law.step({static_cast<double>(second), measured_K, valid, outputs.key_points_K, stepper->temperatures_K(),
                      network->boundaries.operating},
                     1.0);
        if (step.state_rescaled) stepper->set_temperatures(law.rescaled_nodes_K());
      }
      rom::evaluate_boundaries(network->boundaries, network->boundaries.operating,
                               options != nullptr ? law.factors() : none, values);
      EXPECT_EQ(stepper->advance(1.0, values), rom::StepStatus::ok);
    }
    result.push_back(outputs.deformations_m[0]);
    return result;
  }

  /// The same with the estimator in the place of the paper's law.
  static std::vector<double> run_estimator(const Truth& truth) {
    const auto stepper = rom::make_runtime_stepper(*network);
    correction::EstimatorCorrection estimator(*network, {});
    rom::NetworkOutputs outputs = rom::make_network_outputs(*network);
    rom::BoundaryValues values = rom::make_boundary_values(network->boundaries);
    const auto key_points = static_cast<Eigen::Index>(network->key_points.size());
    const auto valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(key_points, true).eval();
    Eigen::VectorXd measured_K(key_points);
    std::vector<double> result;
    for (int second = 0; second <= duration_s; ++second) {
      for (Eigen::Index k = 0; k < key_points; ++k) {
        measured_K[k] = rom::zero_degC_K +
                        truth.seconds[static_cast<std::size_t>(second)].measured_degC[static_cast<std::size_t>(k)];
      }
      const correction::EstimatorStep step = estimator.step(
          {static_cast<double>(second), measured_K, valid, stepper->temperatures_K(), network->boundaries.operating},
          1.0);
      if (step.state_corrected) stepper->set_temperatures(estimator.corrected_nodes_K());
      rom::evaluate_outputs(*network, stepper->temperatures_K(), outputs);
      for (const double kelvin : outputs.key_points_K) result.push_back(kelvin - rom::zero_degC_K);
      rom::OperatingState operating = network->boundaries.operating;
      operating.environment_K += estimator.environment_bias_K();
      rom::evaluate_boundaries(network->boundaries, operating, estimator.factors(), values);
      EXPECT_EQ(stepper->advance(1.0, values), rom::StepStatus::ok);
    }
    result.push_back(outputs.deformations_m[0]);
    return result;
  }

  /// The daemon's own cycle with the demo's configuration; the correction is off until on_s.
  static std::vector<firmware::Snapshot> run_daemon(const Truth& truth, int on_s) {
    const firmware::CyclePlan plan =
        firmware::bind_config(firmware::read_config(SPINDLE_TWIN_SOURCE_DIR "/host_tools/demo_config/twin.toml"),
                              *network)
            .cycle;
    firmware::Cycle cycle(*network, plan, [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
    firmware::PlcCommand command;
    std::vector<firmware::Snapshot> seconds;
    for (int second = 0; second < duration_s; ++second) {
      const PlantSnapshot& plant = truth.seconds[static_cast<std::size_t>(second)];
      const std::int64_t now_ns = 1'000'000'000LL * (second + 1) / 60;
      firmware::DeviceFrame frame;
      frame.connected = true;
      for (std::size_t k = 0; k < plant.measured_degC.size(); ++k) {
        frame.sensors[k] = {plant.measured_degC[k] + rom::zero_degC_K, now_ns};
      }
      frame.signals[0] = {plant.operating.speed_rpm, now_ns};
      frame.signals[1] = {plant.operating.load, now_ns};
      frame.signals[2] = frame.signals[3] = {plant.operating.environment_K[0], now_ns};
      command.correction = second < on_s ? firmware::SwitchOrder::off : firmware::SwitchOrder::on;
      seconds.push_back(cycle.step(frame, command, now_ns, 0));
    }
    return seconds;
  }

  static double error_K(const Truth& truth, const std::vector<firmware::Snapshot>& twin, std::size_t second,
                        std::size_t key_point) {
    return twin[second - 1].predicted_K[key_point] - rom::zero_degC_K - truth.seconds[second].key_point_degC[key_point];
  }

  static Score score(const char* name, const correction::PaperOptions& options) {
    return score(name, [&](const Truth& truth) { return run_twin(truth, &options); });
  }

  template <class Run>
  static Score score(const char* name, const Run& run) {
    Score worst;
    const std::size_t key_points = network->key_points.size();
    for (const Truth& truth : truths) {
      const std::vector<double> twin = run(truth);
      for (std::size_t second = settled_s; second <= duration_s; ++second) {
        for (std::size_t k = 0; k < key_points; ++k) {
          const double error_K = std::abs(twin[second * key_points + k] - truth.seconds[second].key_point_degC[k]);
          worst.key_point_settled_K = std::max(worst.key_point_settled_K, error_K);
          if (second < duration_s / 2) continue;
          worst.key_point_late_K = std::max(worst.key_point_late_K, error_K);
          if (second == duration_s) worst.key_point_end_K = std::max(worst.key_point_end_K, error_K);
        }
      }
      const double true_nose_um = truth.seconds.back().deformation_um[0];
      worst.nose_share = std::max(worst.nose_share, std::abs(1e6 * twin.back() - true_nose_um) /
                                                        std::abs(truths_nominal_nose_um - true_nose_um));
    }
    std::printf(
        "%-38s worst of %d joint sets: key points %.3f K at the end, %.3f K from 900 s, %.3f K from 300 s on; nose "
        "%.3f\n",
        name, joint_sets, worst.key_point_end_K, worst.key_point_late_K, worst.key_point_settled_K, worst.nose_share);
    return worst;
  }

  inline static rom::Network* network = nullptr;
  inline static std::vector<Truth> truths;
  inline static double truths_nominal_nose_um = 0.0;
};

TEST_F(PaperExperiment, default_law_meets_key_points_and_nose_for_every_joint_set) {
  const Score worst = score("default: state rescaled, gamma 1", {});
  EXPECT_LE(worst.key_point_end_K, 0.15);
  EXPECT_LE(worst.key_point_late_K, 0.15);
  EXPECT_LE(worst.nose_share, 0.25);
}

TEST_F(PaperExperiment, estimator_settles_within_five_minutes_and_does_not_ring) {
  const Score worst = score("estimator", [](const Truth& truth) { return run_estimator(truth); });
  EXPECT_LE(worst.key_point_settled_K, 0.1);
  EXPECT_LE(worst.key_point_late_K, 0.05);
  EXPECT_LE(worst.key_point_end_K, 0.05);
}

/// What the paper asks for: its errors at the end are 0.01, 0.02 and 0.15 K; ours may be as large as the sensors' noise
/// and offsets beside that, since no correction sees these.
TEST_F(PaperExperiment, demo_is_on_the_rise_within_five_minutes_and_its_deviations_hold_the_truth) {
  double worst_share = 0.0, worst_end_K = 0.0, worst_ratio = 0.0, worst_nose_um = 0.0;
  for (const Truth& truth : truths) {
    const std::vector<firmware::Snapshot> twin = run_daemon(truth, 0);
    const std::size_t key_points = network->key_points.size();
    double error_sum_K = 0.0, rise_sum_K = 0.0;
    for (std::size_t k = 0; k < key_points; ++k) {
      error_sum_K += error_K(truth, twin, settled_s, k);
      rise_sum_K += truth.seconds[settled_s].key_point_degC[k] - truth.seconds[0].key_point_degC[k];
      worst_end_K = std::max(worst_end_K, std::abs(error_K(truth, twin, duration_s, k)));
    }
    worst_share = std::max(worst_share, std::abs(error_sum_K / rise_sum_K));
    const double nose_m = twin.back().deformation_raw_m[0] - 1e-6 * truth.seconds.back().deformation_um[0];
    worst_ratio = std::max(worst_ratio, std::abs(nose_m) / twin.back().deformation_deviation_m[0]);
    worst_nose_um = std::max(worst_nose_um, 1e6 * std::abs(nose_m));
  }
  std::printf(
      "demo, worst of %d joint sets: %.1f %% of the rise wrong after 300 s, key points %.3f K at the end, nose %.2f "
      "um, "
      "%.2f of its own deviation\n",
      joint_sets, 100.0 * worst_share, worst_end_K, worst_nose_um, worst_ratio);
  EXPECT_LE(worst_share, 0.02);
  EXPECT_LE(worst_end_K, 0.02 + 0.02);
  EXPECT_LE(worst_ratio, 2.0);
}

/// The harder case: switched on when the model without correction has gone wrong by more than a kelvin.
TEST_F(PaperExperiment, switched_on_with_a_large_error_it_takes_that_back_in_five_minutes_and_does_not_ring) {
  constexpr std::size_t on_s = 1200;
  double worst_rest = 0.0, worst_ring = 0.0;
  for (const Truth& truth : truths) {
    const std::vector<firmware::Snapshot> twin = run_daemon(truth, on_s);
    for (std::size_t k = 0; k < network->key_points.size(); ++k) {
      const double initial_K = error_K(truth, twin, on_s, k);
      EXPECT_GT(initial_K, 1.0);
      bool crossed = false;
      for (std::size_t second = on_s + 1; second <= duration_s; ++second) {
        const double share = error_K(truth, twin, second, k) / initial_K;
        crossed = crossed || share < 0.0;
        if (crossed) worst_ring = std::max(worst_ring, std::abs(share));
        if (second >= on_s + settled_s) worst_rest = std::max(worst_rest, std::abs(share));
      }
    }
  }
  std::printf(
      "switched on after %zu s, worst of %d joint sets: %.1f %% of the error left after 300 s, %.1f %% after a "
      "crossing\n",
      on_s, joint_sets, 100.0 * worst_rest, 100.0 * worst_ring);
  EXPECT_LE(worst_rest, 0.02 + 0.02);
  EXPECT_LE(worst_ring, 0.1);
}

TEST_F(PaperExperiment, law_without_state_rescaling_rings_on_at_every_gain) {
  for (const double gain : {1.0, 0.5, 0.3, 0.15, 0.05}) {
    correction::PaperOptions options;
    options.state_rescale = false;
    options.relaxation = gain;
    char name[64];
    std::snprintf(name, sizeof name, "state kept, gamma %.2f", gain);
    EXPECT_GT(score(name, options).key_point_late_K, 0.15);
  }
  correction::PaperOptions published;
  published.state_rescale = false;
  published.guards = spindle_twin::tests::no_guards();
  score("state kept, gamma 1, no guards", published);
}

TEST_F(PaperExperiment, joint_law_does_not_decide_the_result) {
  correction::PaperOptions options;
  options.joint_law = false;
  const Score worst = score("default without the joint law", options);
  EXPECT_LE(worst.key_point_end_K, 0.15);
  EXPECT_LE(worst.nose_share, 0.25);
}

}  // namespace paper_experiment_test
}  // namespace spindle_twin::host_tools

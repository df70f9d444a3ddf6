#include <cmath>
#include <functional>
#include <limits>

#include "correction/paper/paper_correction.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/units.hpp"
#include "tests/bench/campaign/campaign.hpp"

namespace spindle_twin::bench {
namespace {

// Every correction restarts CVODE; the daemon's tolerance would cost most of the campaign for a tenth of a millikelvin.
constexpr double tolerance_K = 1e-4;

std::unique_ptr<rom::FallbackStepper> make_stepper(const rom::Network& network) {
  rom::CvodeSettings settings;
  settings.tolerance_K = tolerance_K;
  return rom::make_runtime_stepper(network, settings);
}

/// One twin in time: the network, what it says, and the inputs it is given.
struct Twin {
  explicit Twin(const rom::Network& the_network)
      : network(the_network),
        stepper(make_stepper(the_network)),
        outputs(rom::make_network_outputs(the_network)),
        values(rom::make_boundary_values(the_network.boundaries)) {
    evaluate();
  }
  void evaluate(double expansion = 1.0) {
    rom::evaluate_outputs(network, stepper->temperatures_K(), outputs, expansion);
  }
  void advance(double period_s, const rom::OperatingState& operating, const rom::CorrectionFactors& factors) {
    rom::evaluate_boundaries(network.boundaries, operating, factors, values);
    if (stepper->advance(period_s, values) != rom::StepStatus::ok) std::abort();
  }
  const rom::Network& network;
  std::unique_ptr<rom::FallbackStepper> stepper;
  rom::NetworkOutputs outputs;
  rom::BoundaryValues values;
};

/// Sums of squares on their way to a score.
struct Judge {
  explicit Judge(const rom::Network& network, int the_sensors) : sensors(the_sensors) {
    for (std::size_t i = 0; i < network.parts.size(); ++i) {
      if (network.parts[i].name == "rotor") rotor = static_cast<Eigen::Index>(i);
    }
  }
  void note(const Truth& truth, Eigen::Index k, const rom::NetworkOutputs& outputs, double deviation_um) {
    if (static_cast<double>(k) * truth.conditions.sample_s < judged_from_s) return;
    const double error_um = rom::um_per_m * (outputs.deformations_m[0] - truth.nose_m[k]);
    sum.error_um += error_um * error_um;
    sum.deviation_um += deviation_um * deviation_um;
    sum.inside += std::abs(error_um) <= 2.0 * deviation_um ? 1.0 : 0.0;
    sum.key_points_K +=
        (outputs.key_points_K.head(sensors) - truth.key_points_K.row(k).transpose().head(sensors)).squaredNorm() /
        sensors;
    sum.rotor_K += std::pow(outputs.part_maximum_K[rotor] - truth.rotor_K[k], 2.0);
    ++count;
  }
  Score score() const {
    const auto n = static_cast<double>(count);
    return {std::sqrt(sum.error_um / n),     std::sqrt(sum.deviation_um / n), sum.inside / n,
            std::sqrt(sum.key_points_K / n), std::sqrt(sum.rotor_K / n),      sum.rejected};
  }
  int sensors;
  Eigen::Index rotor = 0;
  Score sum;
  long count = 0;
};

correction::EstimatorOptions with_sensors(const rom::Network& network, correction::EstimatorOptions options,
                                          int sensors, const Conditions& conditions) {
  options.lag_s = conditions.lag_s;
  options.period_s = conditions.sample_s;
  options.sensors = correction::key_point_sensors(network, options);
  options.sensors.resize(static_cast<std::size_t>(sensors));
  return options;
}

/// Runs the estimator along a truth. `read(k, outputs)` gives the readings, `each(k, estimator, twin)` is called after
/// every sample.
void follow(const rom::Network& network, const Truth& truth, correction::EstimatorCorrection& estimator, bool touch_off,
            const std::function<Eigen::VectorXd(Eigen::Index, const Twin&)>& read,
            const std::function<double(Eigen::Index, const Twin&)>& touch,
            const std::function<void(Eigen::Index, const Twin&)>& each) {
  Twin twin(network);
  const double step_s = truth.conditions.sample_s;
  const auto sensors = static_cast<Eigen::Index>(estimator.sensors().size());
  const auto valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(sensors, true).eval();
  for (Eigen::Index k = 0; k < truth.nose_m.size(); ++k) {
    const double time_s = static_cast<double>(k) * step_s;
    rom::OperatingState operating = truth.read[static_cast<std::size_t>(k)];
    const Eigen::VectorXd measured_K = read(k, twin);
    if (touch_off && k > 0 && std::fmod(time_s, touch_off_s) == 0.0) {
      estimator.note_displacement(0, touch(k, twin), touch_off_m);
    }
    const correction::EstimatorStep step =
        estimator.step({time_s, measured_K, valid, twin.stepper->temperatures_K(), operating}, step_s);
    if (step.state_corrected) {
      twin.stepper->set_temperatures(estimator.corrected_nodes_K());
      twin.evaluate(estimator.factors().expansion);
    }
    each(k, twin);
    operating.environment_K += estimator.environment_bias_K();
    twin.advance(step_s, operating, estimator.factors());
    twin.evaluate(estimator.factors().expansion);
  }
}

}  // namespace

Score run_open_loop(const rom::Network& network, const Truth& truth) {
  Twin twin(network);
  Judge judge(network, static_cast<int>(network.key_points.size()));
  const rom::CorrectionFactors none = rom::no_correction(network.boundaries);
  for (Eigen::Index k = 0; k < truth.nose_m.size(); ++k) {
    judge.note(truth, k, twin.outputs, 0.0);
    twin.advance(truth.conditions.sample_s, truth.read[static_cast<std::size_t>(k)], none);
    twin.evaluate();
  }
  return judge.score();
}

Score run_paper(const rom::Network& network, const Truth& truth, int sensors, bool correct_state) {
  Twin twin(network);
  const double step_s = truth.conditions.sample_s;
  Judge judge(network, sensors);
  correction::PaperOptions options;
  options.state_rescale = correct_state;
  options.groups = correction::common_heat_group(network);
  options.groups.front().key_points.resize(static_cast<std::size_t>(sensors));
  correction::PaperCorrection law(network, options, [&] { return make_stepper(network); });
  const auto valid =
      Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(static_cast<Eigen::Index>(network.key_points.size()), true)
          .eval();
  for (Eigen::Index k = 0; k < truth.nose_m.size(); ++k) {
    const rom::OperatingState& operating = truth.read[static_cast<std::size_t>(k)];
    const Eigen::VectorXd measured_K = truth.measured_K.row(k).transpose();
    const correction::PaperStep step = law.step({static_cast<double>(k) * step_s, measured_K, valid,
                                                 twin.outputs.key_points_K, twin.stepper->temperatures_K(), operating},
                                                step_s);
    if (step.state_rescaled) {
      twin.stepper->set_temperatures(law.rescaled_nodes_K());
      twin.evaluate();
    }
    judge.note(truth, k, twin.outputs, 0.0);
    twin.advance(step_s, operating, law.factors());
    twin.evaluate();
  }
  return judge.score();
}

Score run_estimator(const rom::Network& network, const Truth& truth, int sensors, bool touch_off,
                    const correction::EstimatorOptions& options) {
  correction::EstimatorCorrection estimator(network, with_sensors(network, options, sensors, truth.conditions));
  Judge judge(network, sensors);
  long rejected = 0;
  follow(
      network, truth, estimator, touch_off,
      [&](Eigen::Index k, const Twin&) { return truth.measured_K.row(k).transpose().head(sensors).eval(); },
      [&](Eigen::Index k, const Twin&) { return truth.touch_off_m[k]; },
      [&](Eigen::Index k, const Twin& twin) {
        judge.note(truth, k, twin.outputs, rom::um_per_m * estimator.deviations().deformations_m[0]);
        for (Eigen::Index s = 0; s < sensors; ++s) rejected += estimator.record(s).rejected ? 1 : 0;
      });
  Score score = judge.score();
  score.rejected = rejected;
  return score;
}

Score run_blind(const rom::Network& network, const Truth& truth, const correction::EstimatorOptions& options) {
  correction::EstimatorCorrection estimator(network, with_sensors(network, options, 1, truth.conditions));
  Judge judge(network, 1);
  follow(
      network, truth, estimator, false,
      [](Eigen::Index, const Twin&) {
        return Eigen::VectorXd::Constant(1, std::numeric_limits<double>::quiet_NaN()).eval();
      },
      [](Eigen::Index, const Twin&) { return 0.0; },
      [&](Eigen::Index k, const Twin& twin) {
        judge.note(truth, k, twin.outputs, rom::um_per_m * estimator.deviations().deformations_m[0]);
      });
  return judge.score();
}

double bound_um(const rom::Network& network, const Truth& truth, int sensors, bool touch_off,
                const correction::EstimatorOptions& options) {
  correction::EstimatorOptions linear = with_sensors(network, options, sensors, truth.conditions);
  linear.curvature = 0.0;
  // The bound knows what the truth lacks: no unexplained heat, no lag, a start at the reference temperature.
  linear.priors.disturbance = linear.priors.start_K = linear.lag_deviation_s = 0.0;
  correction::EstimatorCorrection estimator(network, linear);
  estimator.reset(
      0.0, Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), network.boundaries.reference_temperature_K),
      truth.read.front());
  const double step_s = truth.conditions.sample_s;
  double sum_um2 = 0.0;
  long count = 0;
  follow(
      network, truth, estimator, touch_off,
      [&](Eigen::Index k, const Twin& twin) {
        Eigen::VectorXd theta = truth.theta.head(estimator.parameters().count());
        for (Eigen::Index i = 0; i < theta.size(); ++i) {
          const auto& parameter = estimator.parameters().list()[static_cast<std::size_t>(i)];
          if (parameter.kind == correction::ParameterKind::contact)
            theta[i] += drift(truth.conditions, static_cast<double>(k) * step_s);
        }
        estimator.set_parameters(theta);
        return twin.outputs.key_points_K.head(sensors).eval();
      },
      [&](Eigen::Index, const Twin& twin) { return twin.outputs.deformations_m[0]; },
      [&](Eigen::Index k, const Twin&) {
        if (static_cast<double>(k) * step_s < judged_from_s) return;
        const double deviation_um = rom::um_per_m * estimator.deviations().deformations_m[0];
        sum_um2 += deviation_um * deviation_um;
        ++count;
      });
  return std::sqrt(sum_um2 / static_cast<double>(count));
}

}  // namespace spindle_twin::bench

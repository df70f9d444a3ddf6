#include "correction/estimator/output_deviations.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_output_deviations_test {

/// Only the heats are unknown, and nobody reads a sensor: the nose is a sum of lognormal heats, each times a constant.
EstimatorOptions only_heats(double curvature) {
  EstimatorOptions options;
  EstimatorPriors& priors = options.priors;
  priors.contact = priors.film = priors.environment_K = priors.bearing_per_K = priors.speed_exponent =
      priors.expansion = 0.0;
  priors.start_K = priors.disturbance = priors.heat_walk_per_root_min = 0.0;
  options.curvature = curvature;
  return options;
}

void run_unread(Pair& pair) {
  pair.valid.setConstant(false);
  pair.run_until(1800.0);
}

TEST(OutputDeviations, without_curvature_sigma_is_that_of_a_straight_line) {
  const rom::Network network = plates();
  Pair pair(network, only_heats(0.0));
  run_unread(pair);
  const Eigen::VectorXd slope = pair.estimator.sensitivities_K().transpose() * network.deformations[0].row_m_per_K;
  const double deviation_m = pair.estimator.deviations().deformations_m[0];
  EXPECT_NEAR(deviation_m, EstimatorPriors{}.heat * slope.norm(), 1e-9 * deviation_m);
}

TEST(OutputDeviations, two_sigma_reach_the_end_of_the_longer_tail) {
  const rom::Network network = plates();
  Pair pair(network, only_heats(EstimatorOptions{}.curvature));
  run_unread(pair);
  const Eigen::VectorXd slope = pair.estimator.sensitivities_K().transpose() * network.deformations[0].row_m_per_K;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, EstimatorPriors{}.heat);
  std::vector<double> error_m(200000);
  for (double& error : error_m) {
    error = 0.0;
    // θ starts at the mean of the factor, σ²/2 above the median that is drawn from.
    for (const double one : slope) error += one * (std::exp(normal(random) - 0.125) - 1.0);
  }
  std::sort(error_m.begin(), error_m.end());
  const double beyond = 0.5 * std::erfc(std::sqrt(2.0));  // 2σ of a Gaussian
  const auto last = static_cast<double>(error_m.size() - 1);
  const double upper_m = error_m[static_cast<std::size_t>((1.0 - beyond) * last)];
  const double lower_m = -error_m[static_cast<std::size_t>(beyond * last)];
  const double longer_m = std::max(upper_m, lower_m);
  const double deviation_m = pair.estimator.deviations().deformations_m[0];
  EXPECT_NEAR(2.0 * deviation_m, longer_m, 0.07 * longer_m);
  EXPECT_LT(2.0 * EstimatorPriors{}.heat * slope.norm(), 0.88 * longer_m) << "what a straight line would say";
}

TEST(OutputDeviations, of_a_maximum_where_all_points_are_equally_hot_do_not_hang_on_rounding) {
  const rom::Network network = plates();
  const auto deviations_K = [&](double rounding_K) {
    EstimatorCorrection estimator(network, EstimatorOptions{});
    Eigen::VectorXd nodes_K = Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), 300.15);
    for (Eigen::Index i = 0; i < nodes_K.size(); ++i) nodes_K[i] += rounding_K * static_cast<double>(i);
    estimator.reset(0.0, nodes_K, network.boundaries.operating);
    return estimator.deviations().part_maximum_K;
  };
  const Eigen::VectorXd rising_K = deviations_K(1e-12), falling_K = deviations_K(-1e-12);
  for (Eigen::Index part = 0; part < rising_K.size(); ++part) EXPECT_NEAR(rising_K[part], falling_K[part], 1e-9);
}

/// Any S, P and bend, and a certificate that says something else of each output: evaluated directly.
struct Evaluated {
  explicit Evaluated(bool is_skewed) : network(plates()), skewed(is_skewed) {
    network.contact_pressures = {{"fit", 1e6, Eigen::VectorXd::LinSpaced(nodes(), -2e3, 5e3)}};
    network.deformations.push_back({"tail", Eigen::VectorXd::LinSpaced(nodes(), 5e-8, -1e-8)});
    rom::Certificate& certificate = network.certificate;
    certificate.worst.key_points_K = 0.4;
    certificate.worst.part_max_K = 0.6;
    certificate.worst.nose_um = 0.8;
    certificate.key_points_K = {{0.1, 0.0, 0.02, 0.0}, {0.2, 0.0, 0.0, 0.3}};  // of two of the four
    certificate.part_means_K = {{0.5, 0.0, 0.0, 0.0}};
    certificate.deformations_m = {{2e-6, 0.0, 1e-7, 0.0}};
    certificate.contact_pressures_Pa = {};
    std::mt19937_64 random(8);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd root(count(), count());
    for (double& entry : root.reshaped()) entry = 0.1 * normal(random);
    covariance = root * root.transpose() + 0.01 * Eigen::MatrixXd::Identity(count(), count());
    mean = parameters.mean();
    mean[parameters.expansion()] = 0.2;
    Eigen::MatrixXd transposed = Eigen::MatrixXd::Zero(sensitivities.transposed().rows(), nodes());
    for (Eigen::Index i = 0; i < count(); ++i) {
      for (Eigen::Index k = 0; k < nodes(); ++k) transposed(i, k) = 10.0 * normal(random);
    }
    transposed.row(parameters.expansion()).setZero();
    sensitivities.set_transposed(transposed);
    bend = Eigen::VectorXd::LinSpaced(count(), 0.0, 0.05);
    temperatures_K = Eigen::VectorXd::LinSpaced(nodes(), 301.0, 318.0);
    alternatives = Eigen::MatrixXd::Zero(count(), 2);
    alternatives(0, 0) = 0.5;
    alternatives(1, 1) = -0.7;
  }
  OutputDeviations evaluated(bool with_alternatives) {
    SquareRootFilter filter(mean, covariance);
    DeviationOfOutputs outputs(network, sensitivities, parameters, skewed);
    outputs.set_alternatives(alternatives);
    if (!with_alternatives) outputs.clear_alternatives();
    outputs.evaluate(sensitivities, filter, {bend, scale_factor}, temperatures_K);
    return outputs.deviations();
  }
  /// What the header says, of an output with these derivatives by θ.
  double expected(const Eigen::VectorXd& slope, double certificate, bool with_alternatives) const {
    double alternative = 0.0;
    for (Eigen::Index k = 0; with_alternatives && k < 2; ++k) {
      alternative = std::max(alternative, std::abs(alternatives.col(k).dot(slope)));
    }
    const double known = slope.dot(covariance * slope) + slope.cwiseProduct(bend).squaredNorm();
    const double beside = certificate * certificate + alternative * alternative;
    const double variance = known + beside;
    double third = 0.0;
    for (Eigen::Index i = 0; i < count() && skewed; ++i) {
      const ParameterKind kind = parameters.list()[static_cast<std::size_t>(i)].kind;
      const double sign = kind == ParameterKind::heat                                     ? 1.0
                          : kind == ParameterKind::contact || kind == ParameterKind::film ? -1.0
                                                                                          : 0.0;
      third += 3.0 * sign * slope[i] * std::pow(covariance.row(i).dot(slope), 2.0);
    }
    return std::sqrt(scale_factor * scale_factor * known + beside) *
           (1.0 + 0.25 * std::min(2.0, std::abs(third) / std::pow(variance, 1.5)));
  }
  Eigen::VectorXd slope_of(const Eigen::VectorXd& row) const { return sensitivities.in_kelvin().transpose() * row; }
  Eigen::Index nodes() const { return network.capacity_J_per_K.rows(); }
  Eigen::Index count() const { return parameters.count(); }

  rom::Network network;
  bool skewed;
  double scale_factor = 1.7;  ///< of an unlikely machine
  ParameterModel parameters{network, {}};
  Sensitivities sensitivities{network, std::make_shared<const rom::NetworkOperator>(network), parameters};
  Eigen::MatrixXd covariance, alternatives;
  Eigen::VectorXd mean, bend, temperatures_K;
};

TEST(OutputDeviations, are_what_parameters_their_bends_alternatives_and_certificates_leave_open) {
  for (const bool skewed : {true, false}) {
    Evaluated of(skewed);
    for (const bool with_alternatives : {true, false}) {
      const OutputDeviations found = of.evaluated(with_alternatives);
      const auto expect = [&](double deviation, const Eigen::VectorXd& slope, double certificate) {
        const double expected = of.expected(slope, certificate, with_alternatives);
        EXPECT_NEAR(deviation, expected, 1e-9 * expected);
      };
      // Half of the limit, or of the worst case where there is none, and the mesh error in full.
      const double point_K[] = {std::hypot(0.05, 0.02), 0.15, 0.2, 0.2};
      for (std::size_t k = 0; k < 4; ++k) {
        expect(found.key_points_K[static_cast<Eigen::Index>(k)], of.slope_of(of.network.key_points[k].row), point_K[k]);
      }
      for (std::size_t part = 0; part < 4; ++part) {
        const rom::PartOutput& output = of.network.parts[part];
        const auto at = static_cast<Eigen::Index>(part);
        expect(found.part_mean_K[at], of.slope_of(output.mean_row), part == 0 ? 0.25 : 0.3);
        // Temperatures rise along the nodes: the last candidate is the hottest.
        expect(found.part_maximum_K[at], of.slope_of(output.candidate_rows.bottomRows(1).transpose()), 0.3);
      }
      for (std::size_t d = 0; d < 2; ++d) {
        const Eigen::VectorXd& row = of.network.deformations[d].row_m_per_K;
        Eigen::VectorXd slope = std::exp(0.2) * of.slope_of(row);
        slope[of.parameters.expansion()] = std::exp(0.2) * row.dot((of.temperatures_K.array() - 300.15).matrix());
        expect(found.deformations_m[static_cast<Eigen::Index>(d)], slope, d == 0 ? std::hypot(1e-6, 1e-7) : 0.4e-6);
      }
      expect(found.contact_pressures_Pa[0], of.slope_of(of.network.contact_pressures[0].row_Pa_per_K), 0.0);
    }
  }
}

/// A heat alone, known to a factor of e: its error is so skewed that the longer tail is cut.
TEST(OutputDeviations, of_the_most_skewed_error_are_half_as_wide_again_and_no_wider) {
  Evaluated of(true);
  of.scale_factor = 1.0;
  of.bend.setZero();
  of.network.certificate = {};
  of.alternatives.setZero();
  Eigen::MatrixXd transposed = Eigen::MatrixXd::Zero(of.sensitivities.transposed().rows(), of.nodes());
  transposed.row(0).setConstant(3.0);
  of.sensitivities.set_transposed(transposed);
  for (const double deviation : {0.3, 0.8, 1.2}) {
    of.covariance = Eigen::MatrixXd(Eigen::VectorXd::Constant(of.count(), 1e-12).asDiagonal());
    of.covariance(0, 0) = deviation * deviation;
    const double slope = of.slope_of(of.network.key_points[0].row)[0];
    // γ = 3 σ of a single heat.
    const double expected = std::abs(slope) * deviation * (1.0 + 0.25 * std::min(2.0, 3.0 * deviation));
    EXPECT_NEAR(of.evaluated(false).key_points_K[0], expected, 1e-6 * expected) << deviation;
  }
}

TEST(OutputDeviations, of_a_maximum_are_those_of_its_hottest_point_wherever_it_lies) {
  Evaluated of(true);
  for (Eigen::Index hottest = 0; hottest < 9; ++hottest) {
    of.temperatures_K.setConstant(305.0);
    for (Eigen::Index part = 0; part < 4; ++part) of.temperatures_K[9 * part + hottest] = 306.0;
    const OutputDeviations found = of.evaluated(false);
    for (std::size_t part = 0; part < 4; ++part) {
      const Eigen::VectorXd row = of.network.parts[part].candidate_rows.row(hottest).transpose();
      const double expected = of.expected(of.slope_of(row), 0.3, false);
      EXPECT_NEAR(found.part_maximum_K[static_cast<Eigen::Index>(part)], expected, 1e-9 * expected);
    }
  }
}

}  // namespace estimator_output_deviations_test
}  // namespace spindle_twin::correction::test

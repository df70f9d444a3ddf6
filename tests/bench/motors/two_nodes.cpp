#include "tests/bench/motors/two_nodes.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "rom/by_hand/read_by_hand.hpp"

namespace spindle_twin::bench {
namespace {

constexpr double fit_s = 4.0 * 3600.0;
constexpr double sample_s = 60.0;
constexpr double fit_step_s = 4.0;
// The laws as they stand in the network's text below.
constexpr double still_air_share = 0.6, fan_exponent = 0.8, speed_exponent = 1.4, winding_share = 0.4;

struct Laws {
  double film = 0.0;   ///< of the film at rated speed
  double speed = 0.0;  ///< of the loss at rated speed
  double copper = 0.0;
};

Laws laws_at(const MotorInputs& inputs) {
  const double x = std::abs(inputs.speed_share);
  if (x == 0.0) return {still_air_share, 0.0, inputs.load * inputs.load};
  return {still_air_share + (1.0 - still_air_share) * std::pow(x, fan_exponent), std::pow(x, speed_exponent),
          inputs.load * inputs.load};
}

using Series = Eigen::Matrix<double, Eigen::Dynamic, 1>;  // winding and housing of each sample, one after another

Series simulate(const TwoNodes& nodes, const std::vector<MotorInputs>& inputs, double start_K) {
  const double winding_J_per_K = nodes.value(TwoNodes::winding_J_per_K);
  const double housing_J_per_K = nodes.value(TwoNodes::housing_J_per_K);
  const double contact_W_per_K = nodes.value(TwoNodes::contact_W_per_K);
  Series series(2 * static_cast<Eigen::Index>(inputs.size()));
  Eigen::Vector2d now_K = Eigen::Vector2d::Constant(start_K);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const Laws laws = laws_at(inputs[i]);
    const double speed_W = laws.speed * nodes.value(TwoNodes::speed_W);
    const double winding_W = laws.copper * nodes.value(TwoNodes::copper_W) + winding_share * speed_W;
    const double film_W_per_K = laws.film * nodes.value(TwoNodes::film_W_per_K);
    const auto rates = [&](const Eigen::Vector2d& at_K) -> Eigen::Vector2d {
      const double flow_W = contact_W_per_K * (at_K[0] - at_K[1]);
      return {(winding_W - flow_W) / winding_J_per_K,
              ((1.0 - winding_share) * speed_W + flow_W - film_W_per_K * (at_K[1] - inputs[i].ambient_K)) /
                  housing_J_per_K};
    };
    for (double time_s = 0.0; time_s < sample_s; time_s += fit_step_s) {
      const Eigen::Vector2d k1 = rates(now_K), k2 = rates(now_K + 0.5 * fit_step_s * k1);
      const Eigen::Vector2d k3 = rates(now_K + 0.5 * fit_step_s * k2), k4 = rates(now_K + fit_step_s * k3);
      now_K += fit_step_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    series.segment<2>(2 * static_cast<Eigen::Index>(i)) = now_K;
  }
  return series;
}

}  // namespace

double TwoNodes::value(Index i) const { return std::exp(logarithms[i]); }

TwoNodesFit best_two_nodes(const Motor& motor, Random& random) {
  const std::vector<DutySegment> duty = draw_duty(random, fit_s);
  std::vector<MotorInputs> inputs;
  for (double time_s = 0.0; time_s < fit_s; time_s += sample_s) inputs.push_back(inputs_at(duty, time_s));
  const double start_K = inputs.front().ambient_K;
  Motor measured = motor;
  measured.set_uniform(start_K);
  Series truth(2 * static_cast<Eigen::Index>(inputs.size()));
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    measured.advance(sample_s, inputs[i]);
    truth.segment<2>(2 * static_cast<Eigen::Index>(i)) << measured.temperatures_K()[MotorBody::winding],
        measured.temperatures_K()[MotorBody::housing];
  }

  TwoNodes best;
  best.logarithms << std::log(1000.0), std::log(5000.0), std::log(10.0), std::log(5.0), std::log(120.0), std::log(80.0);
  Series residual = truth - simulate(best, inputs, start_K);
  double damping = 1e-2;
  constexpr int most_steps = 60;
  constexpr double difference = 1e-4;
  for (int step = 0; step < most_steps && damping < 1e6; ++step) {
    Eigen::Matrix<double, Eigen::Dynamic, TwoNodes::count> slopes(residual.size(), TwoNodes::count);
    for (Eigen::Index p = 0; p < TwoNodes::count; ++p) {
      TwoNodes other = best;
      other.logarithms[p] += difference;
      slopes.col(p) = (simulate(other, inputs, start_K) - (truth - residual)) / difference;
    }
    Eigen::Matrix<double, TwoNodes::count, TwoNodes::count> normal = slopes.transpose() * slopes;
    normal.diagonal() *= 1.0 + damping;
    TwoNodes tried = best;
    tried.logarithms += normal.ldlt().solve(slopes.transpose() * residual).cwiseMax(-0.7).cwiseMin(0.7);
    const Series left = truth - simulate(tried, inputs, start_K);
    const bool better = left.squaredNorm() < residual.squaredNorm();
    const bool settled = better && left.squaredNorm() > (1.0 - 1e-7) * residual.squaredNorm();
    damping *= better ? 0.2 : 5.0;
    if (!better) continue;
    best = tried;
    residual = left;
    if (settled) break;
  }
  return {best, residual.norm() / std::sqrt(static_cast<double>(residual.size()))};
}

TwoNodes made_wrong(const TwoNodes& fit, const std::array<int, 4>& signs, Random& random) {
  TwoNodes wrong = fit;
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const double share = draw(random, 0.3, 0.5);
    const double toss = draw(random, 0.0, 1.0);
    const bool more = signs[i] > 0 || (signs[i] == 0 && toss < 0.5);
    wrong.logarithms[static_cast<Eigen::Index>(i)] += std::log(more ? 1.0 + share : 1.0 - share);
  }
  return wrong;
}

rom::Network network_of(const TwoNodes& nodes) {
  // Areas of a square metre: a value per square metre is then the conductance.
  std::ostringstream text;
  text.precision(12);
  text << "name = \"motor\"\n[operating]\nspeed_rpm = " << rated_speed_rpm << R"(
reference_temperature_degC = 20.0
temperatures_degC = { room = 20.0 }
[[surrounding]]
name = "room"
kind = "ambient"
[[node]]
name = "winding"
part = "winding"
capacity_J_per_K = )"
       << nodes.value(TwoNodes::winding_J_per_K) << R"(
[[node]]
name = "housing"
part = "housing"
capacity_J_per_K = )"
       << nodes.value(TwoNodes::housing_J_per_K) << R"(
[[contact]]
name = "winding_in_housing"
between = ["winding", "housing"]
area_mm2 = 1e6
conductance_W_per_m2K = )"
       << nodes.value(TwoNodes::contact_W_per_K) << R"(
[[film]]
name = "housing_in_air"
surrounding = "room"
node = "housing"
area_mm2 = 1e6
speed_law = { constant = )"
       << still_air_share << ", speed_terms = [[" << 1.0 - still_air_share << ", " << fan_exponent << R"(]] }
coefficient_W_per_m2K = )"
       << nodes.value(TwoNodes::film_W_per_K) << R"(
[[heat]]
name = "copper"
node = "winding"
speed_law = { load_squared = 1.0 }
heat_W = )"
       << nodes.value(TwoNodes::copper_W) << R"(
[[heat]]
name = "iron_and_friction"
weights = { winding = )"
       << winding_share << ", housing = " << 1.0 - winding_share << R"( }
speed_law = { speed_terms = [[1.0, )"
       << speed_exponent << R"(]] }
heat_W = )"
       << nodes.value(TwoNodes::speed_W) << R"(
[[key_point]]
name = "winding"
node = "winding"
[[key_point]]
name = "housing"
node = "housing"
[[deformation]]
name = "flange"
um_per_K = { housing = 1.5 }
)";
  return rom::parse_by_hand(text.str(), "motor.toml");
}

}  // namespace spindle_twin::bench

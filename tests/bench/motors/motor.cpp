#include "tests/bench/motors/motor.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::bench {
namespace {

constexpr double room_K = 293.15;
constexpr double copper_per_K = 0.0039;  // resistance of copper, from 20 degC on
constexpr double stefan_boltzmann_W_per_m2K4 = 5.670374419e-8;
// The quickest body, a small winding, has a time constant of some 20 s; the classic Runge-Kutta step is then good to
// (0.5 / 20)^5 of what is left of a rise.
constexpr double step_s = 0.5;

double power(double base, double exponent) { return base > 0.0 ? std::pow(base, exponent) : 0.0; }

}  // namespace

std::vector<DutySegment> draw_duty(Random& random, double end_s) {
  std::vector<DutySegment> duty;
  MotorInputs now;
  now.ambient_K = room_K + draw(random, -2.0, 6.0);
  double time_s = 0.0;
  bool stood = false;
  for (int number = 0; time_s < end_s; ++number) {
    const double lasting_s = 60.0 * std::round(draw(random, 8.0, 45.0));
    // The third segment stands if none of the first two did: every duty has a standstill.
    const bool stands = number > 0 && (draw(random, 0.0, 1.0) < 0.2 || (number == 2 && !stood));
    stood = stood || stands;
    now.speed_share = stands ? 0.0 : draw(random, 0.2, 1.15);
    now.load = stands ? 0.0 : draw(random, 0.15, 1.15);
    if (number > 0 && draw(random, 0.0, 1.0) < 0.3) {
      now.ambient_K = std::clamp(now.ambient_K + draw(random, -5.0, 5.0), room_K - 8.0, room_K + 12.0);
    }
    duty.push_back({lasting_s, now});
    time_s += lasting_s;
  }
  return duty;
}

const MotorInputs& inputs_at(const std::vector<DutySegment>& duty, double time_s) {
  for (const DutySegment& segment : duty) {
    if (time_s < segment.lasting_s) return segment.inputs;
    time_s -= segment.lasting_s;
  }
  return duty.back().inputs;
}

Motor::Motor(Random& random) {
  const auto about = [&](double value) { return value * draw(random, 0.7, 1.4); };
  bodies_ = std::uniform_int_distribution<int>(3, 5)(random);
  capacity_J_per_K_ << about(450.0), about(2000.0), about(3500.0), about(1300.0), about(150.0);
  winding_iron_W_per_K_ = about(14.0);
  winding_housing_W_per_K_ = about(1.0);
  iron_housing_W_per_K_ = about(22.0);
  fit_per_K_ = draw(random, -0.005, 0.01);
  gap_W_per_K_ = about(1.2);
  rotor_bearing_W_per_K_ = about(2.5);
  bearing_housing_W_per_K_ = about(6.0);
  shaft_W_per_K_ = about(0.5);
  area_m2_ = about(0.16);
  natural_W_per_m2K_ = about(3.5);
  emissivity_ = draw(random, 0.3, 0.95);
  fan_W_per_K_ = about(1.8);
  copper_W_ = about(110.0);
  iron_W_ = about(60.0);
  friction_W_ = about(18.0);
  friction_per_K_ = draw(random, 0.005, 0.02);
  windage_W_ = about(6.0);
  set_uniform(room_K);
}

BodyTemperatures Motor::rates_K_per_s(const BodyTemperatures& at_K, const MotorInputs& inputs) const {
  using enum MotorBody::Index;
  BodyTemperatures heat_W = BodyTemperatures::Zero();
  const auto exchange = [&](MotorBody::Index a, MotorBody::Index b, double conductance_W_per_K) {
    const double flow_W = conductance_W_per_K * (at_K[a] - at_K[b]);
    heat_W[a] -= flow_W;
    heat_W[b] += flow_W;
  };
  const double x = std::abs(inputs.speed_share);
  const bool has_rotor = bodies_ >= 4, has_bearing = bodies_ >= 5;

  exchange(winding, iron, winding_iron_W_per_K_);
  exchange(winding, housing, winding_housing_W_per_K_ * (0.6 + 0.4 * x));
  exchange(iron, housing, iron_housing_W_per_K_ * std::exp(fit_per_K_ * (at_K[iron] - at_K[housing])));
  if (has_rotor) exchange(rotor, iron, gap_W_per_K_ * (0.4 + 0.6 * power(x, 0.8)));
  if (has_bearing) {
    exchange(rotor, bearing, rotor_bearing_W_per_K_);
    exchange(bearing, housing, bearing_housing_W_per_K_);
  } else if (has_rotor) {
    const double resistance_K_per_W = 1.0 / rotor_bearing_W_per_K_ + 1.0 / bearing_housing_W_per_K_;
    exchange(rotor, housing, 1.0 / resistance_K_per_W);
  }

  const double rise_K = at_K[housing] - inputs.ambient_K;
  const double natural_W = area_m2_ * natural_W_per_m2K_ * power(std::abs(rise_K), 0.25) * rise_K;
  const double radiated_W = area_m2_ * emissivity_ * stefan_boltzmann_W_per_m2K4 *
                            (std::pow(at_K[housing], 4.0) - std::pow(inputs.ambient_K, 4.0));
  heat_W[housing] -= natural_W + radiated_W + fan_W_per_K_ * power(x, 0.8) * rise_K;
  if (has_rotor) heat_W[rotor] -= shaft_W_per_K_ * (0.3 + 0.7 * x) * (at_K[rotor] - inputs.ambient_K);

  heat_W[winding] += copper_W_ * inputs.load * inputs.load * (1.0 + copper_per_K * (at_K[winding] - room_K));
  heat_W[iron] += iron_W_ * power(x, 1.4);
  const MotorBody::Index rubbing = has_bearing ? bearing : housing;
  heat_W[rubbing] += friction_W_ * power(x, 1.2) * std::exp(-friction_per_K_ * (at_K[rubbing] - room_K));
  heat_W[has_rotor ? rotor : iron] += windage_W_ * power(x, 2.8);

  BodyTemperatures rates_K_per_s = heat_W.cwiseQuotient(capacity_J_per_K_);
  rates_K_per_s.tail(MotorBody::count - bodies_).setZero();
  return rates_K_per_s;
}

void Motor::advance(double period_s, const MotorInputs& inputs) {
  const int steps = std::max(1, static_cast<int>(std::ceil(period_s / step_s - 1e-9)));
  const double h_s = period_s / steps;
  for (int i = 0; i < steps; ++i) {
    const BodyTemperatures k1 = rates_K_per_s(temperatures_K_, inputs);
    const BodyTemperatures k2 = rates_K_per_s(temperatures_K_ + 0.5 * h_s * k1, inputs);
    const BodyTemperatures k3 = rates_K_per_s(temperatures_K_ + 0.5 * h_s * k2, inputs);
    const BodyTemperatures k4 = rates_K_per_s(temperatures_K_ + h_s * k3, inputs);
    temperatures_K_ += h_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
}

}  // namespace spindle_twin::bench

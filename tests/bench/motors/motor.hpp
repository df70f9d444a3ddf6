#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

/// Simulated electric motors of another structure than their twin of two nodes: three to five bodies, films that follow
/// temperature and speed, a copper loss that rises with the winding, friction that falls with the bearing.
namespace spindle_twin::bench {

using Random = std::mt19937_64;

inline double draw(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// What the motor does; held for as long as `lasting_s`.
struct MotorInputs {
  double speed_share = 0.0;  ///< of the rated speed
  double load = 0.0;         ///< fraction of the rated load
  double ambient_K = 293.15;
};

struct DutySegment {
  double lasting_s = 0.0;
  MotorInputs inputs;
};

/// Load steps, standstill and steps of the room, until end_s.
std::vector<DutySegment> draw_duty(Random& random, double end_s);

/// The inputs at time_s.
const MotorInputs& inputs_at(const std::vector<DutySegment>& duty, double time_s);

struct MotorBody {
  enum Index : Eigen::Index { winding, iron, housing, rotor, bearing, count };
};
using BodyTemperatures = Eigen::Matrix<double, MotorBody::count, 1>;

class Motor {
 public:
  /// Three, four (with a rotor) or five bodies (with a bearing), all numbers drawn.
  explicit Motor(Random& random);

  int bodies() const { return bodies_; }
  const BodyTemperatures& temperatures_K() const { return temperatures_K_; }
  void set_uniform(double temperature_K) { temperatures_K_.setConstant(temperature_K); }
  void advance(double period_s, const MotorInputs& inputs);

 private:
  BodyTemperatures rates_K_per_s(const BodyTemperatures& at_K, const MotorInputs& inputs) const;

  int bodies_ = 5;
  BodyTemperatures capacity_J_per_K_, temperatures_K_;
  double winding_iron_W_per_K_ = 0.0, winding_housing_W_per_K_ = 0.0, iron_housing_W_per_K_ = 0.0;
  double fit_per_K_ = 0.0;  ///< the contact of iron and housing grows by so much with each kelvin between them
  double gap_W_per_K_ = 0.0, rotor_bearing_W_per_K_ = 0.0, bearing_housing_W_per_K_ = 0.0, shaft_W_per_K_ = 0.0;
  double area_m2_ = 0.0, natural_W_per_m2K_ = 0.0, emissivity_ = 0.0, fan_W_per_K_ = 0.0;
  double copper_W_ = 0.0, iron_W_ = 0.0, friction_W_ = 0.0, friction_per_K_ = 0.0, windage_W_ = 0.0;
};

}  // namespace spindle_twin::bench

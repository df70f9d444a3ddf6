#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace spindle_twin::rom {

/// coefficient · x^exponent, with x = |speed| / reference speed.
struct PowerTerm {
  double coefficient = 0.0;
  double exponent = 0.0;
};

/// Dimensionless factor on a nominal heat or film:
///   scale(x, load) = constant + Σ coefficient_k · x^exponent_k + load_squared · load²,
/// and 0 at standstill if zero_at_standstill. Defaults give the constant 1.
struct SpeedLaw {
  double constant = 1.0;
  std::vector<PowerTerm> speed_terms;
  double load_squared = 0.0;
  bool zero_at_standstill = false;
};

/// What the contact law of an interference fit needs, worked out offline from Lamé's thick-walled rings:
///   dP = pressure_per_inner_rise · dT_inner − pressure_per_outer_rise · dT_outer   [Pa]
/// with dT the mean rises of the two bodies since assembly; side A of the contact is the inner body.
struct JointFit {
  double assembly_pressure_Pa = 0.0;
  double pressure_per_inner_rise_Pa_per_K = 0.0;
  double pressure_per_outer_rise_Pa_per_K = 0.0;
};

enum class ConductanceKind { contact, gap_film, air_film, environment_film };

/// One affine parameter of the model: a contact conductance or a film coefficient.
struct Conductance {
  std::string name;
  ConductanceKind kind = ConductanceKind::contact;
  double nominal_W_per_m2K = 0.0;  ///< at the reference operating state, where `law` is 1
  double area_m2 = 0.0;            ///< wetted or touching area
  int environment = -1;            ///< index into Boundaries::environments; -1 for exchange between bodies
  int part_a = -1;                 ///< index into the part list; -1 when several parts or none
  int part_b = -1;
  SpeedLaw law;
  std::optional<JointFit> fit;
};

struct HeatSource {
  std::string name;
  double nominal_W = 0.0;  ///< at the reference operating state, where `law` is 1
  SpeedLaw law;
};

enum class EnvironmentKind { ambient, coolant };

struct Environment {
  std::string name;
  EnvironmentKind kind = EnvironmentKind::ambient;
};

/// A coolant channel in one dimension: the liquid enters at its environment's temperature and passes the segments one
/// after another. Segment s is the conductance segments[s], an environment film of area A and film coefficient h:
///   q_s = G_s (T_wall,s − T_in,s),  G_s = |ṁ| c (1 − exp(−NTU_s)),  NTU_s = h_s A_s / (|ṁ| c),
///   T_in,s+1 = T_in,s + q_s / (|ṁ| c)
/// with T_wall,s the area mean of the wetted wall. Negative flow passes the segments in the opposite order.
struct CoolantCircuit {
  std::string name;
  int environment = -1;  ///< its temperature is that of the inlet
  double heat_capacity_J_per_kgK = 0.0;
  std::vector<int> segments;  ///< conductances in the order of positive flow; each in one circuit only
};

/// What the machine and its surroundings do at one instant.
struct OperatingState {
  double speed_rpm = 0.0;
  double load = 0.0;                   ///< fraction of the rated load, 1 at the reference state
  Eigen::VectorXd environment_K;       ///< one temperature per environment (coolant inlet, ambient)
  Eigen::VectorXd flow_kg_per_s = {};  ///< one per circuit; negative when it runs backwards
};

/// Everything at the border of the spindle that FE model and network share, in the same order.
struct Boundaries {
  double reference_speed_rpm = 0.0;
  std::vector<Conductance> conductances;
  std::vector<HeatSource> sources;
  std::vector<Environment> environments;
  OperatingState operating;              ///< the description's operating state
  double reference_temperature_K = 0.0;  ///< deformation is zero when everything has this temperature
  std::vector<CoolantCircuit> circuits = {};
};

/// Factors on the nominal values that a correction (or a virtual spindle's hidden truth) sets; all 1 by default.
struct CorrectionFactors {
  Eigen::VectorXd heat;         ///< one per source
  Eigen::VectorXd conductance;  ///< one per conductance
};

/// The right-hand side's inputs at one instant; sized once, refilled in the cycle.
struct BoundaryValues {
  /// For a segment of a circuit the effective G/A of the channel law, for all others the film or contact itself.
  Eigen::VectorXd conductance_W_per_m2K;
  Eigen::VectorXd heat_W;
  Eigen::VectorXd environment_K;
  Eigen::VectorXd coolant_W_per_K = {};  ///< ṁ c, one per circuit, with the sign of the flow
};

}  // namespace spindle_twin::rom

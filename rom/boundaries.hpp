#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "rom/laws/evaluate.hpp"
#include "rom/laws/speed_law.hpp"
#include "rom/range.hpp"

namespace spindle_twin::rom {

/// What the contact law of an interference fit needs, worked out offline from Lamé's thick-walled rings:
///   dP = pressure_per_inner_rise · dT_inner − pressure_per_outer_rise · dT_outer   [Pa]
/// with dT the mean rises of the two bodies since assembly; side A of the contact is the inner body.
struct JointFit {
  double assembly_pressure_Pa = 0.0;
  double pressure_per_inner_rise_Pa_per_K = 0.0;
  double pressure_per_outer_rise_Pa_per_K = 0.0;
};

/// A temperature that a law reads: the mean of a part, or an environment, or, with neither, always nominal_K. Models
/// that hold their laws (the FE model, what is exported) take nominal_K for the part.
struct LawTemperature {
  int part = -1;         ///< index into the part list
  int environment = -1;  ///< index into Boundaries::environments
  double nominal_K = 293.15;
};

/// A physical law and where its inputs come from. Speed, load, current and power are the machine's.
struct BoundLaw {
  PhysicalLaw law;
  LawTemperature first;
  LawTemperature second;
  int pressure = -1;                    ///< index into Network::contact_pressures; -1: always nominal_pressure_Pa
  int displacement = -1;                ///< index into Network::deformations; -1: always 0
  double displacement_sign = 1.0;       ///< times that output: + = the rings come nearer
  double nominal_pressure_Pa = 0.0;     ///< of a model that holds its laws
  double nominal_displacement_m = 0.0;  ///< likewise, with the sign of the output
  int circuit = -1;                     ///< index into Boundaries::circuits, whose flow it reads; -1: none
};

enum class ConductanceKind { contact, gap_film, air_film, environment_film };

/// One affine parameter of the model: a contact conductance or a film coefficient.
struct Conductance {
  std::string name;
  ConductanceKind kind = ConductanceKind::contact;
  double nominal_W_per_m2K = 0.0;  ///< at the reference operating state, where `law` is 1; of physics, at its nominals
  double area_m2 = 0.0;            ///< wetted or touching area
  int environment = -1;            ///< index into Boundaries::environments; -1 for exchange between bodies
  int part_a = -1;                 ///< index into the part list; -1 when several parts or none
  int part_b = -1;
  SpeedLaw law;
  std::optional<JointFit> fit;
  std::optional<BoundLaw> physics = {};  ///< in place of nominal value and `law`
};

struct HeatSource {
  std::string name;
  double nominal_W = 0.0;  ///< at the reference operating state, where `law` is 1; of physics, at its nominal inputs
  SpeedLaw law;
  std::optional<BoundLaw> physics = {};  ///< in place of nominal value and `law`
  /// Its watts are read: OperatingState::heat_W has them; where that does not, they are those of nominal value and
  /// `law`. Not together with physics.
  bool measured = false;
  /// It is friction of a bearing, which falls as the bearing warms: what an estimator's coefficient of that acts on.
  /// Not together with physics, which follows its temperatures itself.
  bool friction = false;
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
  double load = 0.0;                     ///< fraction of the rated load, 1 at the reference state
  Eigen::VectorXd environment_K;         ///< one temperature per environment (coolant inlet, ambient)
  Eigen::VectorXd flow_kg_per_s = {};    ///< one per circuit; negative when it runs backwards
  std::optional<double> current_A = {};  ///< measured phase current of the motor, rms
  std::optional<double> power_W = {};    ///< measured electrical power of the motor
  /// Measured heats, one per source that is `measured`, in the order of the sources; NaN or too few: not known.
  Eigen::VectorXd heat_W = {};
};

/// What a description says is believed of an input or a result, in place of the default (plausible_inputs.hpp).
/// `of`: speed_rpm, load, film_W_per_m2K, contact_W_per_m2K, heat_W (of all sources together), result_K (all
/// temperatures that come out), or an environment [K] or circuit [kg/s] by its name behind these prefixes.
struct PlausibleRange {
  std::string of;
  Range range;
};
inline constexpr const char* plausible_temperature_prefix = "temperature_K.";
inline constexpr const char* plausible_flow_prefix = "flow_kg_per_s.";

/// Everything at the border of the spindle that FE model and network share, in the same order.
struct Boundaries {
  double reference_speed_rpm = 0.0;
  std::vector<Conductance> conductances;
  std::vector<HeatSource> sources;
  std::vector<Environment> environments;
  OperatingState operating;              ///< the description's operating state
  double reference_temperature_K = 0.0;  ///< deformation is zero when everything has this temperature
  std::vector<CoolantCircuit> circuits = {};
  std::vector<PlausibleRange> plausible = {};  ///< of what the description says itself; each `of` once
};

/// Factors on the nominal values that a correction (or a virtual spindle's hidden truth) sets; all 1 by default.
struct CorrectionFactors {
  Eigen::VectorXd heat;         ///< one per source
  Eigen::VectorXd conductance;  ///< one per conductance
  /// Heat put in at each node besides the sources, W: one per node, or empty for none.
  Eigen::VectorXd node_heat_W = {};
  /// Times each node's capacity, > 0: one per node, or empty where all are 1. Only of a network whose capacity matrix
  /// is diagonal (NetworkOperator::diagonal_capacity): a hand-written one.
  Eigen::VectorXd capacity_factor = {};
  double expansion = 1.0;  ///< on every deformation output
};

/// What physical laws read besides temperatures, and the corrections that multiply their values.
struct LawDrive {
  bool follow =
      false;  ///< laws follow the temperatures inside a step; otherwise heats and conductances stay as they are
  double speed_rpm = 0.0;
  double load = 0.0;
  std::optional<double> current_A;
  std::optional<double> power_W;
  Eigen::VectorXd flow_kg_per_s = {};       ///< one per circuit
  Eigen::VectorXd heat_factor = {};         ///< one per source
  Eigen::VectorXd conductance_factor = {};  ///< one per conductance; of a circuit's segment it multiplies the film
};

/// The right-hand side's inputs at one instant; sized once, refilled in the cycle.
struct BoundaryValues {
  /// For a segment of a circuit the effective G/A of the channel law, for all others the film or contact itself.
  Eigen::VectorXd conductance_W_per_m2K;
  Eigen::VectorXd heat_W;
  Eigen::VectorXd environment_K;
  Eigen::VectorXd coolant_W_per_K = {};  ///< ṁ c, one per circuit, with the sign of the flow
  LawDrive laws = {};                    ///< of a network with physical laws
  Eigen::VectorXd node_heat_W = {};      ///< as in CorrectionFactors: one per node, or empty for none
  Eigen::VectorXd capacity_factor = {};  ///< as in CorrectionFactors: one per node, or empty where all are 1
};

}  // namespace spindle_twin::rom

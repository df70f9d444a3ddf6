#pragma once

#include <Eigen/Core>
#include <cmath>

#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/stepper.hpp"
#include "tests/rom/heat_quadrature.hpp"

/// Whether the integrator loses or makes heat.
namespace spindle_twin::rom::tests {

/// Heats over all steps so far, J.
struct HeatBalance {
  double put_in_J = 0.0;                 ///< by the sources and by heats into nodes
  double given_away_J = 0.0;             ///< to the surroundings; negative where they warm the spindle
  double stored_J = 0.0;                 ///< sum of C dT
  double worst_J = 0.0;                  ///< largest residue of one step
  double worst_share = 0.0;              ///< the same beside what all heats put in at their nominal values
  double residue_by_quadrature_J = 0.0;  ///< of steps of 2 s at the most, by HeatQuadrature
  long steps = 0;

  double residue_J() const { return put_in_J - given_away_J - stored_J; }
  /// Beside what was put in.
  double share() const { return std::abs(residue_J()) / put_in_J; }
  double share_by_quadrature() const { return std::abs(residue_by_quadrature_J) / put_in_J; }
};

/// `network` with two nodes more, which touch nothing: their temperatures rise by the heat that the sources have put
/// in and by the heat that the films have given away, both divided by the mean capacity of a node. The first takes
/// every source's heat once more. The second takes one heat per film, of a law that is linear in the temperature of
/// the wall: area · g · (wall − surrounding), from the columns of the film's own factor. So what is put in and given
/// away is integrated as two more states by the integrator that is tried: its multistep formula is linear and keeps any
/// linear sum of states that the equations keep, to rounding. Throws std::invalid_argument for a network with physical
/// laws or coolant circuits.
Network with_meters(const Network& network);

/// Whether with_meters() takes it.
bool takes_meters(const Network& network);

/// The daemon's CvodeStepper on the network with meters, as a stepper of the network without them. After each advance()
/// it adds to the balance what the meters say, and the sum of C dT from the temperatures alone; and, without meters,
/// what HeatQuadrature says. The meters are set back where their rise is large, which is a new start for CVODE, once in
/// an hour or so. Allocates as CvodeStepper does.
class MeteredStepper final : public Stepper {
 public:
  /// `balance` must outlive this.
  MeteredStepper(const Network& network, HeatBalance& balance, const CvodeSettings& settings = {});

  void set_temperatures(const Eigen::VectorXd& temperatures_K) override;
  StepStatus advance(double period_s, const BoundaryValues& values) override;
  const Eigen::VectorXd& temperatures_K() const override { return temperatures_K_; }

 private:
  void take(const BoundaryValues& values);
  static constexpr double quadrature_longest_s = 2.0;
  void add_to_balance(double period_s, const BoundaryValues& values);
  void start_meters();

  Network network_;  ///< with meters
  Eigen::Index nodes_;
  CvodeStepper stepper_;
  HeatBalance& balance_;
  double nominal_W_ = 0.0;
  HeatQuadrature quadrature_;
  Eigen::VectorXd temperatures_K_, before_K_, all_K_;  ///< before_K_: without the meters
  Eigen::Vector2d meters_K_;                           ///< before
  BoundaryValues values_;
};

}  // namespace spindle_twin::rom::tests

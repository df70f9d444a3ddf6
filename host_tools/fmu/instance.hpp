#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host_tools/fmu/variables.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"

namespace spindle_twin::host_tools {

/// What an FMU's slave is at one instant: everything that a later step depends on.
struct FmuState {
  double time_s = 0.0;
  bool started = false;
  std::vector<double> inputs;  ///< per variable; those of outputs are not used
  Eigen::VectorXd temperatures_K;
};

/// One slave: the network of an FMU's resources with the integrator of spindle-twind. Errors are exceptions
/// (rom::InputError for what the importer gave, std::runtime_error for no solution) and leave the slave as it was.
class FmuInstance {
 public:
  /// `resource_location`: URI of the resources folder (file:///... or a bare path). Throws rom::InputError also if
  /// `guid` is not that of the network file in it.
  FmuInstance(const std::string& guid, const std::string& resource_location);

  void set_start_time(double time_s);
  /// Ends the initialisation: temperatures become the start temperature.
  void start();
  /// As after construction.
  void reset();
  double get(unsigned reference);
  void set(unsigned reference, double value);
  /// Advances with the inputs held, as one cycle of the daemon does.
  void step(double time_s, double period_s);
  double time_s() const { return state_.time_s; }

  const FmuState& state() const;
  /// Goes on from there; the integrator starts its history anew.
  void set_state(const FmuState& state);
  /// Sized for this network, for deserialising.
  FmuState make_state() const;

 private:
  void apply_inputs();
  void refresh();
  const FmuVariable& variable(unsigned reference) const;

  rom::Network network_;
  std::vector<FmuVariable> variables_;
  std::unique_ptr<rom::NetworkOperator> operator_;
  std::unique_ptr<rom::FallbackStepper> stepper_;
  mutable FmuState state_;
  rom::OperatingState operating_;
  rom::CorrectionFactors factors_;
  rom::BoundaryValues values_;
  rom::NetworkOutputs outputs_;
  rom::CoolantOutlets coolant_;
  bool fresh_ = false;  ///< values and outputs belong to the present inputs and temperatures
};

}  // namespace spindle_twin::host_tools

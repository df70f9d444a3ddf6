#include "host_tools/fmu/instance.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

/// Path of a file URI (RFC 8089; no authority or "localhost"): %XX is a byte.
std::string path_of(const std::string& location) {
  for (const std::string_view scheme : {"file://localhost/", "file:///", "file:/"}) {
    if (!location.starts_with(scheme)) continue;
    std::string path(1, '/');
    for (std::size_t i = scheme.size(); i < location.size(); ++i) {
      unsigned byte = 0;
      const char* digits = location.data() + i + 1;
      if (location[i] == '%' && i + 2 < location.size() &&
          std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
        path += static_cast<char>(byte);
        i += 2;
      } else {
        path += location[i];
      }
    }
    return path;
  }
  return location;
}

}  // namespace

FmuInstance::FmuInstance(const std::string& guid, const std::string& resource_location) {
  const std::string file = path_of(resource_location) + "/network.rom";
  const std::vector<std::uint8_t> bytes = rom::read_whole_file(file, rom::rom_largest_file_bytes);
  if (fmu_guid(bytes) != guid) {
    std::string message = guid;
    message.append(" is not that of the network, ").append(fmu_guid(bytes));
    throw rom::InputError({file, 0}, "guid", message);
  }
  network_ = rom::decode_network(bytes, file);
  variables_ = fmu_variables(network_);
  operator_ = std::make_unique<rom::NetworkOperator>(network_);
  values_ = rom::make_boundary_values(network_.boundaries);
  outputs_ = rom::make_network_outputs(network_);
  reset();
}

void FmuInstance::reset() {
  stepper_ = rom::make_runtime_stepper(network_);
  operating_ = network_.boundaries.operating;
  factors_ = rom::no_correction(network_.boundaries);
  state_ = make_state();
  fresh_ = false;
}

FmuState FmuInstance::make_state() const {
  FmuState state;
  for (const FmuVariable& item : variables_) state.inputs.push_back(item.start);
  state.temperatures_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network_.nodes.size()));
  return state;
}

const FmuVariable& FmuInstance::variable(unsigned reference) const {
  if (reference < variables_.size()) return variables_[reference];
  std::string field = "value reference ";
  throw rom::InputError({}, field.append(std::to_string(reference)), "does not exist");
}

void FmuInstance::set_start_time(double time_s) {
  if (!std::isfinite(time_s)) throw rom::InputError({}, "start time", "is not finite");
  state_.time_s = time_s;
}

void FmuInstance::start() {
  for (std::size_t i = 0; i < variables_.size(); ++i) {
    if (variables_[i].quantity != FmuQuantity::start_temperature_K) continue;
    stepper_->set_temperatures(
        Eigen::VectorXd::Constant(static_cast<Eigen::Index>(network_.nodes.size()), state_.inputs[i]));
  }
  state_.started = true;
  fresh_ = false;
}

void FmuInstance::set(unsigned reference, double value) {
  const FmuVariable& item = variable(reference);
  if (item.role == FmuRole::output) throw rom::InputError({}, item.name, "is an output and cannot be set");
  if (item.role == FmuRole::fixed_parameter && state_.started) {
    throw rom::InputError({}, item.name, "can be set before the end of the initialisation only");
  }
  const bool is_factor = item.role == FmuRole::tunable_parameter;
  if (!std::isfinite(value) || (item.unit == "K" && value <= 0.0) || (is_factor && value < 0.0)) {
    throw rom::InputError({}, item.name,
                          item.unit == "K" ? "must be finite and above 0 K"
                          : is_factor      ? "must be finite and not negative"
                                           : "must be finite");
  }
  state_.inputs[reference] = value;
  fresh_ = false;
}

void FmuInstance::apply_inputs() {
  for (std::size_t i = 0; i < variables_.size(); ++i) {
    const double value = state_.inputs[i];
    const Eigen::Index index = variables_[i].index;
    switch (variables_[i].quantity) {
      case FmuQuantity::speed_rpm:
        operating_.speed_rpm = value;
        break;
      case FmuQuantity::load:
        operating_.load = value;
        break;
      case FmuQuantity::environment_K:
        operating_.environment_K[index] = value;
        break;
      case FmuQuantity::flow_kg_per_s:
        operating_.flow_kg_per_s[index] = value;
        break;
      case FmuQuantity::measured_heat_W:
        operating_.heat_W[index] = value;
        break;
      case FmuQuantity::heat_factor:
        factors_.heat[index] = value;
        break;
      case FmuQuantity::conductance_factor:
        factors_.conductance[index] = value;
        break;
      default:
        break;
    }
  }
  rom::evaluate_boundaries(network_.boundaries, operating_, factors_, values_);
}

void FmuInstance::refresh() {
  if (fresh_) return;
  if (!state_.started) {
    const bool was_started = state_.started;
    start();  // before the end of the initialisation the outputs are those of the start temperature
    state_.started = was_started;
  }
  apply_inputs();
  rom::evaluate_outputs(network_, stepper_->temperatures_K(), outputs_);
  coolant_ = rom::coolant_outlets(*operator_, values_, stepper_->temperatures_K());
  fresh_ = true;
}

double FmuInstance::get(unsigned reference) {
  const FmuVariable& item = variable(reference);
  if (item.role != FmuRole::output) return state_.inputs[reference];
  refresh();
  switch (item.quantity) {
    case FmuQuantity::key_point_K:
      return outputs_.key_points_K[item.index];
    case FmuQuantity::part_mean_K:
      return outputs_.part_mean_K[item.index];
    case FmuQuantity::part_maximum_K:
      return outputs_.part_maximum_K[item.index];
    case FmuQuantity::deformation_m:
      return outputs_.deformations_m[item.index];
    case FmuQuantity::contact_pressure_Pa:
      return outputs_.contact_pressures_Pa[item.index];
    case FmuQuantity::heat_W:
      return values_.heat_W[item.index];
    case FmuQuantity::coolant_outlet_K:
      return coolant_.outlet_K[item.index];
    case FmuQuantity::coolant_heat_W:
      return coolant_.heat_W[item.index];
    default:
      throw std::logic_error("an output without a quantity");
  }
}

void FmuInstance::step(double time_s, double period_s) {
  if (!state_.started) throw rom::InputError({}, "step", "before the end of the initialisation");
  constexpr double rounding = 1e-9;
  if (!(std::abs(time_s - state_.time_s) <= rounding * std::max(1.0, std::abs(state_.time_s)))) {
    throw rom::InputError(
        {}, "communication point",
        std::to_string(time_s) + std::string(" s, but the last step ended at ") + std::to_string(state_.time_s));
  }
  if (!(period_s > 0.0) || !std::isfinite(period_s)) {
    throw rom::InputError({}, "communication step", "must be finite and above 0 s");
  }
  apply_inputs();
  if (stepper_->advance(period_s, values_) != rom::StepStatus::ok) {
    std::string message = "no solution over ";
    throw std::runtime_error(
        message.append(std::to_string(period_s)).append(" s from ").append(std::to_string(time_s)));
  }
  state_.time_s = time_s + period_s;
  fresh_ = false;
}

const FmuState& FmuInstance::state() const {
  state_.temperatures_K = stepper_->temperatures_K();
  return state_;
}

void FmuInstance::set_state(const FmuState& state) {
  state_ = state;
  stepper_->set_temperatures(state.temperatures_K);
  fresh_ = false;
}

}  // namespace spindle_twin::host_tools

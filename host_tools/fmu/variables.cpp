#include "host_tools/fmu/variables.hpp"

#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/read/sha256.hpp"

namespace spindle_twin::host_tools {
namespace {

struct Kind {
  FmuRole role;
  FmuQuantity quantity;
  const char* unit;
};

class List {
 public:
  void add(const Kind& kind, const std::string& name, const std::string& description, double start = 0.0,
           Eigen::Index index = 0) {
    variables_.push_back({name, description, kind.unit, kind.role, kind.quantity, index, start});
  }
  /// One per item, named <prefix>.<item's name>.
  template <class Items, class Start>
  void add_each(const Kind& kind, const std::string& prefix, const std::string& description, const Items& items,
                Start start) {
    for (std::size_t i = 0; i < items.size(); ++i) {
      const auto index = static_cast<Eigen::Index>(i);
      add(kind, std::string(prefix).append(".").append(items[i].name), description, start(index), index);
    }
  }
  std::vector<FmuVariable> take() { return std::move(variables_); }

 private:
  std::vector<FmuVariable> variables_;
};

}  // namespace

std::vector<FmuVariable> fmu_variables(const rom::Network& network) {
  const rom::Boundaries& boundaries = network.boundaries;
  const rom::OperatingState& operating = boundaries.operating;
  const auto one = [](Eigen::Index) { return 1.0; };
  const auto none = [](Eigen::Index) { return 0.0; };
  List list;
  std::size_t measured = 0;
  using enum FmuRole;
  using enum FmuQuantity;
  list.add({input, speed_rpm, "rpm"}, "speed", "spindle speed", operating.speed_rpm);
  list.add({input, load, ""}, "load", "fraction of the rated load", operating.load);
  list.add_each({input, environment_K, "K"}, "environment", "temperature of ambient or of coolant at the inlet",
                boundaries.environments, [&](Eigen::Index i) { return operating.environment_K[i]; });
  list.add_each({input, FmuQuantity::flow_kg_per_s, "kg/s"}, "flow", "coolant flow, negative when it runs backwards",
                boundaries.circuits, [&](Eigen::Index i) { return operating.flow_kg_per_s[i]; });
  for (const std::size_t heat : rom::measured_heats(boundaries)) {
    const auto index = static_cast<Eigen::Index>(measured++);
    list.add({input, FmuQuantity::measured_heat_W, "W"}, "measured_heat." + boundaries.sources[heat].name,
             "measured watts of a heat source", boundaries.sources[heat].nominal_W, index);
  }
  list.add({fixed_parameter, start_temperature_K, "K"}, "start_temperature", "uniform temperature at the start",
           rom::rest_temperature_K(boundaries, operating));
  list.add_each({tunable_parameter, heat_factor, ""}, "heat_factor", "factor on a heat source", boundaries.sources,
                one);
  list.add_each({tunable_parameter, conductance_factor, ""}, "conductance_factor", "factor on a contact or film",
                boundaries.conductances, one);
  list.add_each({output, key_point_K, "K"}, "temperature", "key point", network.key_points, none);
  list.add_each({output, part_mean_K, "K"}, "mean_temperature", "volume mean of a part", network.parts, none);
  list.add_each({output, part_maximum_K, "K"}, "maximum_temperature", "maximum of a part", network.parts, none);
  list.add_each({output, deformation_m, "m"}, "deformation", "positive when the spindle is longer",
                network.deformations, none);
  list.add_each({output, contact_pressure_Pa, "Pa"}, "contact_pressure", "mean pressure of a joint",
                network.contact_pressures, none);
  list.add_each({output, heat_W, "W"}, "heat", "heat of a source", boundaries.sources, none);
  list.add_each({output, coolant_outlet_K, "K"}, "coolant_outlet", "coolant at the outlet", boundaries.circuits, none);
  list.add_each({output, coolant_heat_W, "W"}, "coolant_heat", "heat that the coolant takes", boundaries.circuits,
                none);
  return list.take();
}

std::string fmu_guid(std::span<const std::uint8_t> rom_file) {
  const std::string digits = rom::hex(rom::sha256(rom_file));
  std::string guid = "{";
  std::size_t from = 0;
  for (const std::size_t length : {8, 4, 4, 4, 12}) {
    if (from > 0) guid += '-';
    guid += digits.substr(from, length);
    from += length;
  }
  return guid += '}';
}

}  // namespace spindle_twin::host_tools

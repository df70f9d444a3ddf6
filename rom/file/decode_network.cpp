#include <Eigen/Core>
#include <algorithm>
#include <cstring>
#include <limits>

#include "rom/boundary_values/held_law.hpp"
#include "rom/file/decode_certificate.hpp"
#include "rom/file/decode_fields.hpp"
#include "rom/file/decode_law.hpp"
#include "rom/file/rom.pb.h"
#include "rom/read/input_error.hpp"

namespace spindle_twin::rom {
namespace {

bool decode_term(pb_istream_t* stream, PowerTerm& item) {
  spindle_twin_rom_PowerTerm message = spindle_twin_rom_PowerTerm_init_zero;
  if (!pb_decode(stream, spindle_twin_rom_PowerTerm_fields, &message)) return false;
  item = {message.coefficient, message.exponent};
  return true;
}

void attach_law(spindle_twin_rom_SpeedLaw& message, SpeedLaw& law) {
  message.speed_terms = attach_list<PowerTerm, decode_term>(law.speed_terms);
}

void decode_law(const spindle_twin_rom_SpeedLaw& message, SpeedLaw& law) {
  law.constant = message.constant;
  law.load_squared = message.load_squared;
  law.zero_at_standstill = message.zero_at_standstill;
}

/// nanopb stores whatever number came; reading it through the C enum would be undefined beyond the enum's range.
template <class Enum>
unsigned number_of(const Enum& value) {
  static_assert(sizeof(Enum) == sizeof(unsigned));
  unsigned number = 0;
  std::memcpy(&number, &value, sizeof number);  // std::bit_cast reads the enum as an enum: the sanitizer refuses it
  return number;
}

struct ConductanceWithFactor {
  Conductance conductance;
  Eigen::MatrixXd factor_m;
  std::string law_fault;
};

bool decode_conductance(pb_istream_t* stream, ConductanceWithFactor& item) {
  Conductance& conductance = item.conductance;
  spindle_twin_rom_Conductance message = spindle_twin_rom_Conductance_init_zero;
  message.name = attach(conductance.name);
  message.factor_m = attach(item.factor_m);
  attach_law(message.law, conductance.law);
  DecodedLaw physics;
  attach_physics(message.physics, physics);
  if (!pb_decode(stream, spindle_twin_rom_Conductance_fields, &message)) return false;
  if (message.has_physics) conductance.physics = decode_physics(message.physics, physics, item.law_fault);
  if (number_of(message.kind) > static_cast<unsigned>(ConductanceKind::environment_film)) {
    PB_RETURN_ERROR(stream, "a conductance of unknown kind");
  }
  conductance.kind = static_cast<ConductanceKind>(number_of(message.kind));
  conductance.nominal_W_per_m2K = message.nominal_W_per_m2K;
  conductance.area_m2 = message.area_m2;
  conductance.environment = message.environment;
  conductance.part_a = message.part_a;
  conductance.part_b = message.part_b;
  decode_law(message.law, conductance.law);
  if (message.has_fit) {
    conductance.fit = JointFit{message.fit.assembly_pressure_Pa, message.fit.pressure_per_inner_rise_Pa_per_K,
                               message.fit.pressure_per_outer_rise_Pa_per_K};
  }
  return true;
}

struct SourceWithDistribution {
  HeatSource source;
  Eigen::VectorXd distribution;
  std::string law_fault;
};

bool decode_source(pb_istream_t* stream, SourceWithDistribution& item) {
  spindle_twin_rom_HeatSource message = spindle_twin_rom_HeatSource_init_zero;
  message.name = attach(item.source.name);
  message.distribution = attach(item.distribution);
  attach_law(message.law, item.source.law);
  DecodedLaw physics;
  attach_physics(message.physics, physics);
  if (!pb_decode(stream, spindle_twin_rom_HeatSource_fields, &message)) return false;
  if (message.has_physics) item.source.physics = decode_physics(message.physics, physics, item.law_fault);
  item.source.nominal_W = message.nominal_W;
  item.source.measured = message.measured;
  decode_law(message.law, item.source.law);
  item.source.friction = message.has_friction ? message.friction : is_friction_unless_said(item.source.law);
  return true;
}

struct EnvironmentWithTemperature {
  Environment environment;
  double operating_K = 0.0;
};

bool decode_environment(pb_istream_t* stream, EnvironmentWithTemperature& item) {
  spindle_twin_rom_Environment message = spindle_twin_rom_Environment_init_zero;
  message.name = attach(item.environment.name);
  if (!pb_decode(stream, spindle_twin_rom_Environment_fields, &message)) return false;
  if (number_of(message.kind) > static_cast<unsigned>(EnvironmentKind::coolant)) {
    PB_RETURN_ERROR(stream, "an environment of unknown kind");
  }
  item.environment.kind = static_cast<EnvironmentKind>(number_of(message.kind));
  item.operating_K = message.operating_K;
  return true;
}

struct CircuitWithFlow {
  CoolantCircuit circuit;
  double operating_kg_per_s = 0.0;
};

bool decode_indices(pb_istream_t* stream, Field, void** arg) {
  while (stream->bytes_left > 0) {
    std::int64_t index = 0;
    if (!pb_decode_svarint(stream, &index)) return false;
    auto& indices = *static_cast<std::vector<int>*>(*arg);
    if (index < 0 || index > std::numeric_limits<int>::max()) PB_RETURN_ERROR(stream, "a segment out of range");
    if (indices.size() == most_items) PB_RETURN_ERROR(stream, "too many segments");
    indices.push_back(static_cast<int>(index));
  }
  return true;
}

bool decode_circuit(pb_istream_t* stream, CircuitWithFlow& item) {
  spindle_twin_rom_CoolantCircuit message = spindle_twin_rom_CoolantCircuit_init_zero;
  message.name = attach(item.circuit.name);
  message.segments = attach(&item.circuit.segments, decode_indices);
  if (!pb_decode(stream, spindle_twin_rom_CoolantCircuit_fields, &message)) return false;
  item.circuit.environment = message.environment;
  item.circuit.heat_capacity_J_per_kgK = message.heat_capacity_J_per_kgK;
  item.operating_kg_per_s = message.operating_kg_per_s;
  return true;
}

bool decode_node(pb_istream_t* stream, Node& item) {
  spindle_twin_rom_Node message = spindle_twin_rom_Node_init_zero;
  message.name = attach(item.name);
  message.part = attach(item.part);
  if (!pb_decode(stream, spindle_twin_rom_Node_fields, &message)) return false;
  item.r_m = message.r_m;
  item.z_m = message.z_m;
  return true;
}

bool decode_key_point(pb_istream_t* stream, KeyPoint& item) {
  spindle_twin_rom_KeyPoint message = spindle_twin_rom_KeyPoint_init_zero;
  message.name = attach(item.name);
  message.part = attach(item.part);
  message.row = attach(item.row);
  if (!pb_decode(stream, spindle_twin_rom_KeyPoint_fields, &message)) return false;
  item.r_m = message.r_m;
  item.z_m = message.z_m;
  return true;
}

bool decode_part(pb_istream_t* stream, PartOutput& item) {
  spindle_twin_rom_PartOutput message = spindle_twin_rom_PartOutput_init_zero;
  message.name = attach(item.name);
  message.mean_row = attach(item.mean_row);
  message.candidate_rows = attach(item.candidate_rows);
  return pb_decode(stream, spindle_twin_rom_PartOutput_fields, &message);
}

bool decode_deformation(pb_istream_t* stream, DeformationOutput& item) {
  spindle_twin_rom_DeformationOutput message = spindle_twin_rom_DeformationOutput_init_zero;
  message.name = attach(item.name);
  message.row_m_per_K = attach(item.row_m_per_K);
  return pb_decode(stream, spindle_twin_rom_DeformationOutput_fields, &message);
}

bool decode_contact_pressure(pb_istream_t* stream, ContactPressureOutput& item) {
  spindle_twin_rom_ContactPressureOutput message = spindle_twin_rom_ContactPressureOutput_init_zero;
  message.name = attach(item.name);
  message.row_Pa_per_K = attach(item.row_Pa_per_K);
  if (!pb_decode(stream, spindle_twin_rom_ContactPressureOutput_fields, &message)) return false;
  item.assembly_pressure_Pa = message.assembly_pressure_Pa;
  return true;
}

bool decode_plausible(pb_istream_t* stream, PlausibleRange& item) {
  spindle_twin_rom_PlausibleRange message = spindle_twin_rom_PlausibleRange_init_zero;
  message.of = attach(item.of);
  if (!pb_decode(stream, spindle_twin_rom_PlausibleRange_fields, &message)) return false;
  item.range = between(message.lowest, message.highest);
  return true;
}

bool decode_outline(pb_istream_t* stream, OutlineRing& item) {
  spindle_twin_rom_OutlineRing message = spindle_twin_rom_OutlineRing_init_zero;
  message.part = attach(item.part);
  message.points_m = attach(item.points_m);
  return pb_decode(stream, spindle_twin_rom_OutlineRing_fields, &message);
}

/// Gives a column of numbers its shape; a size that does not fit is an error of `field`.
void shape(Eigen::MatrixXd& numbers, Eigen::Index rows, Eigen::Index columns, const std::string& file,
           const std::string& field) {
  if (numbers.size() != rows * columns) {
    throw InputError({file, 0}, field,
                     std::to_string(numbers.size()) + " numbers where " + std::to_string(rows) + " x " +
                         std::to_string(columns) + " are needed");
  }
  numbers.resize(rows, columns);
}

void check_length(const Eigen::VectorXd& numbers, Eigen::Index nodes, const std::string& file,
                  const std::string& field) {
  if (numbers.size() == nodes) return;
  throw InputError(
      {file, 0}, field,
      std::to_string(numbers.size()) + " numbers where one per node, " + std::to_string(nodes) + ", is needed");
}

/// What nanopb fills; lists that the network keeps in matrices come with their columns.
struct Lists {
  std::vector<ConductanceWithFactor> conductances;
  std::vector<SourceWithDistribution> sources;
  std::vector<EnvironmentWithTemperature> environments;
  std::vector<CircuitWithFlow> circuits;
};

void refuse_law(const std::string& fault, const std::string& file, const std::string& field) {
  if (!fault.empty()) throw InputError({file, 0}, field, fault);
}

void decode_lists(Lists& lists, Network& network, const std::string& file) {
  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  for (ConductanceWithFactor& item : lists.conductances) {
    const Eigen::Index columns = item.factor_m.size() / nodes;
    shape(item.factor_m, nodes, columns, file, "conductance " + item.conductance.name + " factor");
    refuse_law(item.law_fault, file, "conductance " + item.conductance.name + " law");
    network.boundaries.conductances.push_back(std::move(item.conductance));
    network.factors_m.push_back(std::move(item.factor_m));
  }
  for (const SourceWithDistribution& item : lists.sources) {
    check_length(item.distribution, nodes, file, "source " + item.source.name + " distribution");
    refuse_law(item.law_fault, file, "source " + item.source.name + " law");
  }
  network.source_distribution.resize(nodes, static_cast<Eigen::Index>(lists.sources.size()));
  for (std::size_t i = 0; i < lists.sources.size(); ++i) {
    SourceWithDistribution& item = lists.sources[i];
    network.source_distribution.col(static_cast<Eigen::Index>(i)) = item.distribution;
    network.boundaries.sources.push_back(std::move(item.source));
  }
  Eigen::VectorXd& environment_K = network.boundaries.operating.environment_K;
  environment_K.resize(static_cast<Eigen::Index>(lists.environments.size()));
  for (std::size_t i = 0; i < lists.environments.size(); ++i) {
    environment_K[static_cast<Eigen::Index>(i)] = lists.environments[i].operating_K;
    network.boundaries.environments.push_back(std::move(lists.environments[i].environment));
  }
  Eigen::VectorXd& flow_kg_per_s = network.boundaries.operating.flow_kg_per_s;
  flow_kg_per_s.resize(static_cast<Eigen::Index>(lists.circuits.size()));
  for (std::size_t i = 0; i < lists.circuits.size(); ++i) {
    flow_kg_per_s[static_cast<Eigen::Index>(i)] = lists.circuits[i].operating_kg_per_s;
    network.boundaries.circuits.push_back(std::move(lists.circuits[i].circuit));
  }
}

void shape_outputs(Network& network, const std::string& file) {
  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  for (const KeyPoint& point : network.key_points) {
    check_length(point.row, nodes, file, "key point " + point.name + " row");
  }
  for (PartOutput& part : network.parts) {
    check_length(part.mean_row, nodes, file, "part " + part.name + " mean row");
    shape(part.candidate_rows, part.candidate_rows.size() / nodes, nodes, file, "part " + part.name + " candidates");
  }
  for (const DeformationOutput& output : network.deformations) {
    check_length(output.row_m_per_K, nodes, file, "deformation " + output.name + " row");
  }
  for (const ContactPressureOutput& output : network.contact_pressures) {
    check_length(output.row_Pa_per_K, nodes, file, "contact pressure " + output.name + " row");
  }
  for (OutlineRing& ring : network.outlines) {
    shape(ring.points_m, 2, ring.points_m.size() / 2, file, "outline of " + ring.part);
  }
}

/// What a version did not know must not be in its files: an older program would have read them otherwise.
void check_version(const spindle_twin_rom_Network& message, const Lists& lists, const FlatErrors& errors,
                   const std::string& file) {
  const std::uint32_t version = message.schema_version;
  if (version < payload_schema_version_oldest || version > payload_schema_version) {
    throw InputError({file, 0}, "schema_version",
                     std::to_string(version) + " is unknown; this program reads " +
                         std::to_string(payload_schema_version_oldest) + " to " +
                         std::to_string(payload_schema_version));
  }
  if (version < payload_schema_version_circuits && !lists.circuits.empty()) {
    throw InputError({file, 0}, "schema_version", "1 with coolant circuits, which come with version 2");
  }
  if (version < payload_schema_version_outputs && (message.hand_written || !errors.empty())) {
    throw InputError({file, 0}, "schema_version",
                     std::to_string(version) + " with a hand-written network or errors per output, which come with 3");
  }
  const bool laws =
      std::any_of(lists.conductances.begin(), lists.conductances.end(),
                  [](const ConductanceWithFactor& item) { return item.conductance.physics.has_value(); }) ||
      std::any_of(lists.sources.begin(), lists.sources.end(),
                  [](const SourceWithDistribution& item) { return item.source.physics.has_value(); });
  if (version < payload_schema_version_laws && laws) {
    throw InputError({file, 0}, "schema_version",
                     std::to_string(version) + " with physical laws, which come with version 4");
  }
  const bool measured = std::any_of(lists.sources.begin(), lists.sources.end(),
                                    [](const SourceWithDistribution& item) { return item.source.measured; });
  if (version < payload_schema_version_measured && measured) {
    throw InputError({file, 0}, "schema_version",
                     std::to_string(version) + " with measured heats, which come with version 5");
  }
  if (version < payload_schema_version_limits &&
      (message.certificate.has_limit || message.certificate.limit_content != 0.0)) {
    throw InputError({file, 0}, "schema_version",
                     std::to_string(version) + " with limits of the errors, which come with version 6");
  }
}

}  // namespace

DecodedPayload decode_payload(std::span<const std::uint8_t> payload, const std::string& file) {
  Network network;
  Lists lists;
  FlatErrors errors;
  spindle_twin_rom_Network message = spindle_twin_rom_Network_init_zero;
  message.spindle = attach(network.spindle);
  message.description_hash = attach(network.description_hash);
  message.nodes = attach_list<Node, decode_node>(network.nodes);
  message.capacity_J_per_K = attach(network.capacity_J_per_K);
  message.conduction_W_per_K = attach(network.conduction_W_per_K);
  message.conductances = attach_list<ConductanceWithFactor, decode_conductance>(lists.conductances);
  message.sources = attach_list<SourceWithDistribution, decode_source>(lists.sources);
  message.environments = attach_list<EnvironmentWithTemperature, decode_environment>(lists.environments);
  message.circuits = attach_list<CircuitWithFlow, decode_circuit>(lists.circuits);
  message.key_points = attach_list<KeyPoint, decode_key_point>(network.key_points);
  message.parts = attach_list<PartOutput, decode_part>(network.parts);
  message.deformations = attach_list<DeformationOutput, decode_deformation>(network.deformations);
  message.contact_pressures = attach_list<ContactPressureOutput, decode_contact_pressure>(network.contact_pressures);
  message.outlines = attach_list<OutlineRing, decode_outline>(network.outlines);
  message.plausible = attach_list<PlausibleRange, decode_plausible>(network.boundaries.plausible);

  attach_certificate(message.certificate, errors);

  pb_istream_t stream = pb_istream_from_buffer(payload.data(), payload.size());
  if (!pb_decode(&stream, spindle_twin_rom_Network_fields, &message)) {
    throw InputError({file, 0}, "payload", std::string("malformed: ") + PB_GET_ERROR(&stream));
  }
  check_version(message, lists, errors, file);
  if (network.nodes.empty()) throw InputError({file, 0}, "nodes", "none; at least one is needed");

  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  shape(network.capacity_J_per_K, nodes, nodes, file, "capacity_J_per_K");
  shape(network.conduction_W_per_K, nodes, nodes, file, "conduction_W_per_K");
  decode_lists(lists, network, file);
  shape_outputs(network, file);
  network.boundaries.reference_speed_rpm = message.reference_speed_rpm;
  network.boundaries.operating.speed_rpm = message.operating_speed_rpm;
  network.boundaries.operating.load = message.operating_load;
  network.boundaries.operating.heat_W = unread_heats_W(network.boundaries);
  network.boundaries.reference_temperature_K = message.reference_temperature_K;
  network.hand_written = message.hand_written;
  network.certificate = decode_certificate(message.certificate, errors, message.schema_version, file);
  return {std::move(network), message.schema_version};
}

}  // namespace spindle_twin::rom

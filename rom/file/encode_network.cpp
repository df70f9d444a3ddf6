#include <pb_encode.h>

#include <Eigen/Core>

#include "rom/file/decode_certificate.hpp"
#include "rom/file/payload.hpp"
#include "rom/file/rom.pb.h"
#include "rom/laws/law_fields.hpp"
#include "rom/require.hpp"

namespace spindle_twin::rom {
namespace {

using Field = const pb_field_t*;

// nanopb calls these back with the `arg` that the functions below attach to a member of the network.

bool encode_text(pb_ostream_t* stream, Field field, void* const* arg) {
  const auto& text = *static_cast<const std::string*>(*arg);
  if (text.empty()) return true;
  return pb_encode_tag_for_field(stream, field) &&
         pb_encode_string(stream, reinterpret_cast<const pb_byte_t*>(text.data()), text.size());
}

template <class Matrix>
bool encode_numbers(pb_ostream_t* stream, Field field, void* const* arg) {
  const auto& numbers = *static_cast<const Matrix*>(*arg);
  if (numbers.size() == 0) return true;
  if (!pb_encode_tag(stream, PB_WT_STRING, field->tag) ||
      !pb_encode_varint(stream, static_cast<std::uint64_t>(numbers.size()) * sizeof(double))) {
    return false;
  }
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    if (!pb_encode_fixed64(stream, numbers.data() + i)) return false;
  }
  return true;
}

/// A list of messages; encode_item(stream, list, i) writes the i-th one after its tag.
template <class List, bool (*encode_item)(pb_ostream_t*, const List&, std::size_t)>
bool encode_list(pb_ostream_t* stream, Field field, void* const* arg) {
  const auto& list = *static_cast<const List*>(*arg);
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (!pb_encode_tag_for_field(stream, field) || !encode_item(stream, list, i)) return false;
  }
  return true;
}

pb_callback_t attach(const void* item, bool (*encode)(pb_ostream_t*, Field, void* const*)) {
  pb_callback_t callback{};
  callback.funcs.encode = encode;
  callback.arg = const_cast<void*>(item);  // nanopb has one pointer type for both directions
  return callback;
}

pb_callback_t attach(const std::string& text) { return attach(&text, encode_text); }
pb_callback_t attach(const Eigen::VectorXd& numbers) { return attach(&numbers, encode_numbers<Eigen::VectorXd>); }
pb_callback_t attach(const Eigen::MatrixXd& numbers) { return attach(&numbers, encode_numbers<Eigen::MatrixXd>); }

template <class List, bool (*encode_item)(pb_ostream_t*, const List&, std::size_t)>
pb_callback_t attach_list(const List& list) {
  return attach(&list, encode_list<List, encode_item>);
}

using Terms = std::vector<PowerTerm>;
bool encode_term(pb_ostream_t* stream, const Terms& terms, std::size_t i) {
  const spindle_twin_rom_PowerTerm message{terms[i].coefficient, terms[i].exponent};
  return pb_encode_submessage(stream, spindle_twin_rom_PowerTerm_fields, &message);
}

spindle_twin_rom_SpeedLaw law_message(const SpeedLaw& law) {
  spindle_twin_rom_SpeedLaw message = spindle_twin_rom_SpeedLaw_init_zero;
  message.constant = law.constant;
  message.speed_terms = attach_list<Terms, encode_term>(law.speed_terms);
  message.load_squared = law.load_squared;
  message.zero_at_standstill = law.zero_at_standstill;
  return message;
}

/// A law's parts as nanopb wants them, alive while it encodes.
struct EncodedLaw {
  std::string kind;
  std::vector<NamedNumber> numbers;

  explicit EncodedLaw(const std::optional<BoundLaw>& physics) {
    if (!physics) return;
    kind = traits_of(physics->law).kind;
    numbers = law_numbers(physics->law.parameters);
  }
};

bool encode_law_number(pb_ostream_t* stream, const std::vector<NamedNumber>& list, std::size_t i) {
  spindle_twin_rom_LawNumber message = spindle_twin_rom_LawNumber_init_zero;
  message.name = attach(list[i].name);
  message.value = list[i].value;
  return pb_encode_submessage(stream, spindle_twin_rom_LawNumber_fields, &message);
}

spindle_twin_rom_PhysicalLaw physics_message(const BoundLaw& physics, const EncodedLaw& encoded) {
  spindle_twin_rom_PhysicalLaw message = spindle_twin_rom_PhysicalLaw_init_zero;
  message.kind = attach(encoded.kind);
  message.mode = static_cast<std::uint32_t>(physics.law.mode);
  message.numbers = attach_list<std::vector<NamedNumber>, encode_law_number>(encoded.numbers);
  message.has_first = message.has_second = true;
  message.first = {physics.first.part, physics.first.environment, physics.first.nominal_K};
  message.second = {physics.second.part, physics.second.environment, physics.second.nominal_K};
  message.pressure = physics.pressure;
  message.displacement = physics.displacement;
  message.displacement_sign = physics.displacement_sign;
  message.nominal_pressure_Pa = physics.nominal_pressure_Pa;
  message.nominal_displacement_m = physics.nominal_displacement_m;
  message.circuit = physics.circuit;
  return message;
}

/// Lists that the network keeps apart from the matrices they own are encoded from the network itself.
template <class Item>
struct NetworkList {
  const Network* network;
  const std::vector<Item>* items;
  std::size_t size() const { return items->size(); }
};

bool encode_conductance(pb_ostream_t* stream, const NetworkList<Conductance>& list, std::size_t i) {
  const Conductance& item = (*list.items)[i];
  spindle_twin_rom_Conductance message = spindle_twin_rom_Conductance_init_zero;
  message.name = attach(item.name);
  message.kind = static_cast<spindle_twin_rom_ConductanceKind>(item.kind);
  message.nominal_W_per_m2K = item.nominal_W_per_m2K;
  message.area_m2 = item.area_m2;
  message.environment = item.environment;
  message.part_a = item.part_a;
  message.part_b = item.part_b;
  message.has_law = true;
  message.law = law_message(item.law);
  message.has_fit = item.fit.has_value();
  if (item.fit) {
    message.fit = {item.fit->assembly_pressure_Pa, item.fit->pressure_per_inner_rise_Pa_per_K,
                   item.fit->pressure_per_outer_rise_Pa_per_K};
  }
  message.factor_m = attach(list.network->factors_m[i]);
  const EncodedLaw encoded(item.physics);
  message.has_physics = item.physics.has_value();
  if (item.physics) message.physics = physics_message(*item.physics, encoded);
  return pb_encode_submessage(stream, spindle_twin_rom_Conductance_fields, &message);
}

bool encode_source(pb_ostream_t* stream, const NetworkList<HeatSource>& list, std::size_t i) {
  const HeatSource& item = (*list.items)[i];
  const Eigen::VectorXd distribution = list.network->source_distribution.col(static_cast<Eigen::Index>(i));
  spindle_twin_rom_HeatSource message = spindle_twin_rom_HeatSource_init_zero;
  message.name = attach(item.name);
  message.nominal_W = item.nominal_W;
  message.measured = item.measured;
  message.has_friction = item.friction != is_friction_unless_said(item.law);
  message.friction = item.friction;
  message.has_law = true;
  message.law = law_message(item.law);
  message.distribution = attach(distribution);
  const EncodedLaw encoded(item.physics);
  message.has_physics = item.physics.has_value();
  if (item.physics) message.physics = physics_message(*item.physics, encoded);
  return pb_encode_submessage(stream, spindle_twin_rom_HeatSource_fields, &message);
}

bool encode_environment(pb_ostream_t* stream, const NetworkList<Environment>& list, std::size_t i) {
  const Environment& item = (*list.items)[i];
  spindle_twin_rom_Environment message = spindle_twin_rom_Environment_init_zero;
  message.name = attach(item.name);
  message.kind = static_cast<spindle_twin_rom_EnvironmentKind>(item.kind);
  message.operating_K = list.network->boundaries.operating.environment_K[static_cast<Eigen::Index>(i)];
  return pb_encode_submessage(stream, spindle_twin_rom_Environment_fields, &message);
}

bool encode_indices(pb_ostream_t* stream, Field field, void* const* arg) {
  for (const int index : *static_cast<const std::vector<int>*>(*arg)) {
    if (!pb_encode_tag(stream, PB_WT_VARINT, field->tag) || !pb_encode_svarint(stream, index)) return false;
  }
  return true;
}

bool encode_circuit(pb_ostream_t* stream, const NetworkList<CoolantCircuit>& list, std::size_t i) {
  const CoolantCircuit& item = (*list.items)[i];
  spindle_twin_rom_CoolantCircuit message = spindle_twin_rom_CoolantCircuit_init_zero;
  message.name = attach(item.name);
  message.environment = item.environment;
  message.heat_capacity_J_per_kgK = item.heat_capacity_J_per_kgK;
  message.operating_kg_per_s = list.network->boundaries.operating.flow_kg_per_s[static_cast<Eigen::Index>(i)];
  message.segments = attach(&item.segments, encode_indices);
  return pb_encode_submessage(stream, spindle_twin_rom_CoolantCircuit_fields, &message);
}

bool encode_node(pb_ostream_t* stream, const std::vector<Node>& list, std::size_t i) {
  spindle_twin_rom_Node message = spindle_twin_rom_Node_init_zero;
  message.name = attach(list[i].name);
  message.part = attach(list[i].part);
  message.r_m = list[i].r_m;
  message.z_m = list[i].z_m;
  return pb_encode_submessage(stream, spindle_twin_rom_Node_fields, &message);
}

bool encode_key_point(pb_ostream_t* stream, const std::vector<KeyPoint>& list, std::size_t i) {
  spindle_twin_rom_KeyPoint message = spindle_twin_rom_KeyPoint_init_zero;
  message.name = attach(list[i].name);
  message.part = attach(list[i].part);
  message.r_m = list[i].r_m;
  message.z_m = list[i].z_m;
  message.row = attach(list[i].row);
  return pb_encode_submessage(stream, spindle_twin_rom_KeyPoint_fields, &message);
}

bool encode_part(pb_ostream_t* stream, const std::vector<PartOutput>& list, std::size_t i) {
  spindle_twin_rom_PartOutput message = spindle_twin_rom_PartOutput_init_zero;
  message.name = attach(list[i].name);
  message.mean_row = attach(list[i].mean_row);
  message.candidate_rows = attach(list[i].candidate_rows);
  return pb_encode_submessage(stream, spindle_twin_rom_PartOutput_fields, &message);
}

bool encode_deformation(pb_ostream_t* stream, const std::vector<DeformationOutput>& list, std::size_t i) {
  spindle_twin_rom_DeformationOutput message = spindle_twin_rom_DeformationOutput_init_zero;
  message.name = attach(list[i].name);
  message.row_m_per_K = attach(list[i].row_m_per_K);
  return pb_encode_submessage(stream, spindle_twin_rom_DeformationOutput_fields, &message);
}

using Pressures = std::vector<ContactPressureOutput>;
bool encode_contact_pressure(pb_ostream_t* stream, const Pressures& list, std::size_t i) {
  spindle_twin_rom_ContactPressureOutput message = spindle_twin_rom_ContactPressureOutput_init_zero;
  message.name = attach(list[i].name);
  message.assembly_pressure_Pa = list[i].assembly_pressure_Pa;
  message.row_Pa_per_K = attach(list[i].row_Pa_per_K);
  return pb_encode_submessage(stream, spindle_twin_rom_ContactPressureOutput_fields, &message);
}

bool encode_plausible(pb_ostream_t* stream, const std::vector<PlausibleRange>& list, std::size_t i) {
  spindle_twin_rom_PlausibleRange message = spindle_twin_rom_PlausibleRange_init_zero;
  message.of = attach(list[i].of);
  message.lowest = list[i].range.min;
  message.highest = list[i].range.max;
  return pb_encode_submessage(stream, spindle_twin_rom_PlausibleRange_fields, &message);
}

bool encode_outline(pb_ostream_t* stream, const std::vector<OutlineRing>& list, std::size_t i) {
  spindle_twin_rom_OutlineRing message = spindle_twin_rom_OutlineRing_init_zero;
  message.part = attach(list[i].part);
  message.points_m = attach(list[i].points_m);
  return pb_encode_submessage(stream, spindle_twin_rom_OutlineRing_fields, &message);
}

spindle_twin_rom_CertificateErrors errors_message(const CertificateErrors& errors) {
  return {errors.key_points_K, errors.nose_um, errors.part_max_K};
}

/// Worst, median, mesh, limit of one output after the other.
Eigen::VectorXd flat(const std::vector<OutputError>& errors) {
  Eigen::VectorXd numbers(4 * static_cast<Eigen::Index>(errors.size()));
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const OutputError& error = errors[i];
    numbers.segment<4>(4 * static_cast<Eigen::Index>(i)) << error.worst, error.median, error.mesh, error.limit;
  }
  return numbers;
}

FlatErrors flat(const Certificate& certificate) {
  return {flat(certificate.key_points_K), flat(certificate.part_means_K), flat(certificate.part_maxima_K),
          flat(certificate.deformations_m), flat(certificate.contact_pressures_Pa)};
}

spindle_twin_rom_Certificate certificate_message(const Certificate& certificate, const FlatErrors& errors) {
  spindle_twin_rom_Certificate message = spindle_twin_rom_Certificate_init_zero;
  message.seed = certificate.seed;
  message.cases = certificate.cases;
  message.has_worst = true;
  message.worst = errors_message(certificate.worst);
  message.has_median = true;
  message.median = errors_message(certificate.median);
  message.has_limit = true;
  message.limit = errors_message(certificate.limit);
  message.limit_content = certificate.limit_rule.content;
  message.limit_confidence = certificate.limit_rule.confidence;
  message.limit_fitted = certificate.limit_rule.fitted;
  message.searched = certificate.searched;
  message.has_worst_found = certificate.searched > 0;
  message.worst_found = errors_message(certificate.worst_found);
  message.has_box = true;
  message.box = {certificate.box.contact_low, certificate.box.contact_high, certificate.box.film_low,
                 certificate.box.film_high, certificate.box.speed_high_rpm};
  message.mesh_size_m = certificate.mesh_size_m;
  message.fe_unknowns = certificate.fe_unknowns;
  message.key_points_K = attach(errors.key_points_K);
  message.part_means_K = attach(errors.part_means_K);
  message.part_maxima_K = attach(errors.part_maxima_K);
  message.deformations_m = attach(errors.deformations_m);
  message.contact_pressures_Pa = attach(errors.contact_pressures_Pa);
  return message;
}

}  // namespace

std::vector<std::uint8_t> encode_payload(const Network& network) {
  const Boundaries& boundaries = network.boundaries;
  require(network.factors_m.size() == boundaries.conductances.size(), "not one factor per conductance");
  require(network.source_distribution.cols() == static_cast<Eigen::Index>(boundaries.sources.size()),
          "not one column of the source distribution per source");
  require(boundaries.operating.environment_K.size() == static_cast<Eigen::Index>(boundaries.environments.size()),
          "not one operating temperature per environment");
  require(boundaries.operating.flow_kg_per_s.size() == static_cast<Eigen::Index>(boundaries.circuits.size()),
          "not one operating flow per coolant circuit");

  const NetworkList<Conductance> conductances{&network, &boundaries.conductances};
  const NetworkList<HeatSource> sources{&network, &boundaries.sources};
  const NetworkList<Environment> environments{&network, &boundaries.environments};
  const NetworkList<CoolantCircuit> circuits{&network, &boundaries.circuits};

  spindle_twin_rom_Network message = spindle_twin_rom_Network_init_zero;
  message.schema_version = payload_schema_version;
  message.hand_written = network.hand_written;
  message.spindle = attach(network.spindle);
  message.description_hash = attach(network.description_hash);
  message.nodes = attach_list<std::vector<Node>, encode_node>(network.nodes);
  message.capacity_J_per_K = attach(network.capacity_J_per_K);
  message.conduction_W_per_K = attach(network.conduction_W_per_K);
  message.reference_speed_rpm = boundaries.reference_speed_rpm;
  message.conductances = attach_list<NetworkList<Conductance>, encode_conductance>(conductances);
  message.sources = attach_list<NetworkList<HeatSource>, encode_source>(sources);
  message.environments = attach_list<NetworkList<Environment>, encode_environment>(environments);
  message.circuits = attach_list<NetworkList<CoolantCircuit>, encode_circuit>(circuits);
  message.operating_speed_rpm = boundaries.operating.speed_rpm;
  message.operating_load = boundaries.operating.load;
  message.reference_temperature_K = boundaries.reference_temperature_K;
  message.key_points = attach_list<std::vector<KeyPoint>, encode_key_point>(network.key_points);
  message.parts = attach_list<std::vector<PartOutput>, encode_part>(network.parts);
  message.deformations = attach_list<std::vector<DeformationOutput>, encode_deformation>(network.deformations);
  message.contact_pressures = attach_list<Pressures, encode_contact_pressure>(network.contact_pressures);
  message.outlines = attach_list<std::vector<OutlineRing>, encode_outline>(network.outlines);
  message.plausible = attach_list<std::vector<PlausibleRange>, encode_plausible>(boundaries.plausible);
  message.has_certificate = true;
  const FlatErrors errors = flat(network.certificate);
  message.certificate = certificate_message(network.certificate, errors);

  std::size_t size = 0;
  require(pb_get_encoded_size(&size, spindle_twin_rom_Network_fields, &message), "the network cannot be encoded");
  std::vector<std::uint8_t> payload(size);
  pb_ostream_t stream = pb_ostream_from_buffer(payload.data(), payload.size());
  require(pb_encode(&stream, spindle_twin_rom_Network_fields, &message), "the network cannot be encoded");
  return payload;
}

}  // namespace spindle_twin::rom

#include "host_tools/commands/offline/solved_field.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "host_tools/inspection/inspection.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {

using fem_offline::AffineModel;

namespace {

nlohmann::json as_json(const fem_offline::Stress& stress) {
  return {{"rr", megapascal_per_pascal * stress.rr_Pa},
          {"zz", megapascal_per_pascal * stress.zz_Pa},
          {"tt", megapascal_per_pascal * stress.tt_Pa},
          {"rz", megapascal_per_pascal * stress.rz_Pa},
          {"von_mises", megapascal_per_pascal * fem_offline::von_mises_Pa(stress)}};
}

}  // namespace

SolvedField solved_field(const AffineModel& model, const rom::BoundaryValues& values,
                         const Eigen::VectorXd& temperatures_K, double datum_K) {
  SolvedField field;
  field.datum_K = datum_K;
  for (const auto& part : model.parts) {
    PartRise rise{-1e9, 1e9};
    for (const int dof : part.dofs) {
      rise.max_K = std::max(rise.max_K, temperatures_K[dof] - datum_K);
      rise.min_K = std::min(rise.min_K, temperatures_K[dof] - datum_K);
    }
    field.parts.push_back(rise);
  }
  for (const auto& point : model.key_points) field.key_points_K.push_back(point.row.dot(temperatures_K) - datum_K);
  const Eigen::VectorXd warmed_K = temperatures_K.array() - model.boundaries.reference_temperature_K;
  for (const auto& output : model.deformations) {
    field.deformation_um.push_back(rom::um_per_m * output.row_m_per_K.dot(warmed_K));
  }
  for (const auto& output : model.contact_pressures) {
    field.contact_pressure_MPa.push_back(megapascal_per_pascal *
                                         (output.assembly_pressure_Pa + output.row_Pa_per_K.dot(warmed_K)));
  }
  field.heat = fem_offline::heat_balance(model, values, temperatures_K);
  field.coolant = fem_offline::coolant_outlets(model, values, temperatures_K);
  return field;
}

nlohmann::json as_json(const AffineModel& model, const SolvedField& field) {
  nlohmann::json json;
  json["spindle"] = model.spindle;
  json["unknowns"] = model.places.size();
  for (std::size_t p = 0; p < model.parts.size(); ++p) {
    json["rise_K"]["max"][model.parts[p].name] = field.parts[p].max_K;
    json["rise_K"]["min"][model.parts[p].name] = field.parts[p].min_K;
  }
  json["rise_K"]["key_points"] = field.key_points_K;
  json["deformation_um"] = nlohmann::json::object();
  for (std::size_t d = 0; d < model.deformations.size(); ++d) {
    json["deformation_um"][model.deformations[d].name] = field.deformation_um[d];
  }
  for (std::size_t c = 0; c < model.contact_pressures.size(); ++c) {
    json["contact_pressure_MPa"][model.contact_pressures[c].name] = field.contact_pressure_MPa[c];
  }
  for (const auto& [name, stress] : field.stresses) json["stress_MPa"][name] = as_json(stress);
  for (const auto& conductance : model.boundaries.conductances) {
    json["nominal_W_per_m2K"][conductance.name] = conductance.nominal_W_per_m2K;
  }
  for (std::size_t c = 0; c < model.boundaries.circuits.size(); ++c) {
    const auto index = static_cast<Eigen::Index>(c);
    json["coolant"][model.boundaries.circuits[c].name] = {
        {"outlet_degC", field.coolant.outlet_K[index] - rom::zero_degC_K}, {"heat_W", field.coolant.heat_W[index]}};
  }
  json["heat_in_W"] = field.heat.heat_in_W;
  json["heat_out_W"] = field.heat.heat_out_W;
  return json;
}

void print_table(const AffineModel& model, const SolvedField& field) {
  std::printf("%s: %zu unknowns, rises above %.2f degC\n\n", model.spindle.c_str(), model.places.size(),
              field.datum_K - rom::zero_degC_K);
  std::printf("%-24s %10s %10s\n", "part", "max K", "min K");
  for (std::size_t p = 0; p < model.parts.size(); ++p) {
    std::printf("%-24s %10.3f %10.3f\n", model.parts[p].name.c_str(), field.parts[p].max_K, field.parts[p].min_K);
  }
  std::printf("\n");
  for (std::size_t k = 0; k < model.key_points.size(); ++k) {
    std::printf("%-24s %10.3f K\n", model.key_points[k].name.c_str(), field.key_points_K[k]);
  }
  for (std::size_t d = 0; d < model.deformations.size(); ++d) {
    std::printf("%-24s %10.3f um\n", model.deformations[d].name.c_str(), field.deformation_um[d]);
  }
  for (std::size_t c = 0; c < model.contact_pressures.size(); ++c) {
    std::printf("%-24s %10.3f MPa\n", model.contact_pressures[c].name.c_str(), field.contact_pressure_MPa[c]);
  }
  for (const auto& [name, stress] : field.stresses) {
    std::printf("%-24s %10.3f MPa von Mises\n", name.c_str(), megapascal_per_pascal * von_mises_Pa(stress));
  }
  for (std::size_t c = 0; c < model.boundaries.circuits.size(); ++c) {
    const auto index = static_cast<Eigen::Index>(c);
    std::printf("%-24s %10.3f W, outlet %.3f degC\n", model.boundaries.circuits[c].name.c_str(),
                field.coolant.heat_W[index], field.coolant.outlet_K[index] - rom::zero_degC_K);
  }
  std::printf("%-24s %10.3f W\n%-24s %10.3f W\n", "heat in", field.heat.heat_in_W, "heat out", field.heat.heat_out_W);
}

}  // namespace spindle_twin::host_tools

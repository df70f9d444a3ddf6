#include "host_tools/commands/offline/solved_series.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "host_tools/commands/column_names.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {

using fem_offline::AffineModel;

namespace {

void print_header(const std::string& file, const AffineModel& model) {
  ColumnNames names(file);
  for (const auto& point : model.key_points) names.add(point.name, "_degC", "key point");
  for (const auto& part : model.parts) names.add(part.name, "_max_degC", "part");
  for (const auto& output : model.deformations) names.add(output.name, "_um", "deformation");
  for (const auto& output : model.contact_pressures) names.add(output.name, "_MPa", "contact pressure");
  for (const auto& circuit : model.boundaries.circuits) {
    names.add(circuit.name, "_outlet_degC", "coolant circuit");
    names.add(circuit.name, "_heat_W", "coolant circuit");
  }
  std::printf("%s\n", names.text().c_str());
}

void print_row(double time_s, const SolvedField& field) {
  const double datum_degC = field.datum_K - rom::zero_degC_K;
  std::printf("%.3f", time_s);
  for (const double rise_K : field.key_points_K) std::printf(",%.4f", datum_degC + rise_K);
  for (const PartRise& rise : field.parts) std::printf(",%.4f", datum_degC + rise.max_K);
  for (const double moved_um : field.deformation_um) std::printf(",%.4f", moved_um);
  for (const double pressure_MPa : field.contact_pressure_MPa) std::printf(",%.4f", pressure_MPa);
  for (Eigen::Index c = 0; c < field.coolant.heat_W.size(); ++c) {
    std::printf(",%.4f,%.4f", field.coolant.outlet_K[c] - rom::zero_degC_K, field.coolant.heat_W[c]);
  }
  std::printf("\n");
}

void append_row(const AffineModel& model, double time_s, const SolvedField& field, nlohmann::json& series) {
  series["time_s"].push_back(time_s);
  series["key_points_K"].push_back(field.key_points_K);
  for (std::size_t p = 0; p < field.parts.size(); ++p) {
    series["part_max_K"][model.parts[p].name].push_back(field.parts[p].max_K);
  }
  for (std::size_t d = 0; d < field.deformation_um.size(); ++d) {
    series["deformation_um"][model.deformations[d].name].push_back(field.deformation_um[d]);
  }
  for (std::size_t c = 0; c < model.boundaries.circuits.size(); ++c) {
    const auto index = static_cast<Eigen::Index>(c);
    auto& circuit = series["coolant"][model.boundaries.circuits[c].name];
    circuit["outlet_degC"].push_back(field.coolant.outlet_K[index] - rom::zero_degC_K);
    circuit["heat_W"].push_back(field.coolant.heat_W[index]);
  }
}

}  // namespace

SolvedSeries::SolvedSeries(const std::string& file, const AffineModel& model, bool json)
    : model_(&model), series_(json ? std::make_unique<nlohmann::json>() : nullptr) {
  if (!json) print_header(file, model);
}

SolvedSeries::~SolvedSeries() = default;

void SolvedSeries::add(double time_s, const SolvedField& field) {
  if (series_) {
    append_row(*model_, time_s, field, *series_);
  } else {
    print_row(time_s, field);
  }
}

const nlohmann::json& SolvedSeries::json() const {
  static const nlohmann::json none;
  return series_ ? *series_ : none;
}

}  // namespace spindle_twin::host_tools

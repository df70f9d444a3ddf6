#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"

namespace spindle_twin::host_tools {

struct PartRise {
  double max_K = 0.0;
  double min_K = 0.0;
};

/// What `solve` reports of one field, in the model's order of parts, key points, outputs and circuits; rises are above
/// `datum_K`.
struct SolvedField {
  double datum_K = 0.0;
  std::vector<PartRise> parts;
  std::vector<double> key_points_K;
  std::vector<double> deformation_um;
  std::vector<double> contact_pressure_MPa;
  std::vector<fem_offline::ProbedStress> stresses;  ///< empty unless the caller fills it: they cost an elastic solution
  fem_offline::HeatBalance heat;
  rom::CoolantOutlets coolant;
};

SolvedField solved_field(const fem_offline::AffineModel& model, const rom::BoundaryValues& values,
                         const Eigen::VectorXd& temperatures_K, double datum_K);

/// The keys of fem_offline/README.md.
nlohmann::json as_json(const fem_offline::AffineModel& model, const SolvedField& field);

/// The same for a person, on stdout.
void print_table(const fem_offline::AffineModel& model, const SolvedField& field);

}  // namespace spindle_twin::host_tools

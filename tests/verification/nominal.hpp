#pragma once

#include <string>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {

inline std::string spindle_file(const std::string& name) {
  std::string path = SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/";
  path.append(name).append(".toml");  // a chain of + is taken for a write beyond the end by GCC 12
  return path;
}

/// Everything at the description's operating state.
inline rom::BoundaryValues nominal_values(const AffineModel& model) {
  rom::BoundaryValues values = rom::make_boundary_values(model.boundaries);
  rom::evaluate_boundaries(model.boundaries, model.boundaries.operating, rom::no_correction(model.boundaries), values);
  return values;
}

inline const FePart& part_named(const AffineModel& model, const std::string& name) {
  for (const FePart& part : model.parts) {
    if (part.name == name) return part;
  }
  throw std::out_of_range("no part " + name);
}

inline double part_maximum(const AffineModel& model, const std::string& name, const Eigen::VectorXd& field) {
  double most = -1e300;
  for (const int dof : part_named(model, name).dofs) most = std::max(most, field[dof]);
  return most;
}

inline double part_minimum(const AffineModel& model, const std::string& name, const Eigen::VectorXd& field) {
  return -part_maximum(model, name, -field);
}

}  // namespace spindle_twin::fem_offline

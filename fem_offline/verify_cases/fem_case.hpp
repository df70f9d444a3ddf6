#pragma once

#include <string>
#include <vector>

#include "fem_offline/model/build_model.hpp"

/// Descriptions with a known answer, and what our model makes of them.
namespace spindle_twin::fem_offline {

/// One figure of a case beside its target.
struct CheckedFigure {
  std::string figure;  ///< what, of what, when
  std::string unit;
  double target = 0.0;
  double result = 0.0;
  double error = 0.0;      ///< fraction of the temperature span for temperatures, of the target for others
  double tolerance = 0.0;  ///< largest |error|
  bool passed = false;
  std::string source;
};

struct CaseResult {
  std::string id;  ///< the description's name
  std::string proves;
  std::size_t unknowns = 0;
  std::vector<CheckedFigure> figures;
};

/// The folder with the cases of the source tree that this was built from.
std::string default_cases_directory();

/// All descriptions (*.toml) of a folder by name. Throws rom::InputError if there are none.
std::vector<std::string> case_files(const std::string& directory);

/// Reads, meshes with element sizes times `mesh_factor` and every element cut in four `halvings` times, solves (steady,
/// and along the schedule as far as the last time asked for) and compares. Throws rom::InputError for a bad description
/// or one without expectations.
CaseResult run_case(const std::string& path, double mesh_factor, int halvings = 0);

/// Observed orders of convergence on smooth fields with a closed form, over four meshes of the descriptions in
/// `directory`/orders with 8, 4, 2 and 1 times their element sizes: error ~ h^order, from the second and the last.
std::vector<CaseResult> run_orders(const std::string& directory);

/// Effectivity of the mesh error's estimate (mesh/error_left.hpp), estimated over true error, on meshes of 8 times the
/// element sizes of the descriptions in `directory`: for every figure whose answer is exact and whose error is above
/// that of the answer's digits and of the steps in time. Passed from 0.7 to 1.5.
std::vector<CaseResult> run_mesh_estimates(const std::string& directory);

}  // namespace spindle_twin::fem_offline

#include <cmath>
#include <filesystem>

#include "fem_offline/mesh/error_left.hpp"
#include "fem_offline/verify_cases/fem_case.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Of the element sizes: on the usual meshes the errors of most cases drown in the digits of their answers.
constexpr double mesh_factor = 8.0;
/// Errors below this are left out, as a fraction of the span or of the target: those of the answers' digits and of the
/// steps in time are of that size.
constexpr double least_error = 2e-5;
/// A figure that may be further off has no exact answer. One that may not be off at all is a law, and has no mesh
/// error.
constexpr double largest_tolerance = 2e-3, largest_rounding = 1e-8;
constexpr double least_index = 0.7, largest_index = 1.5;

CheckedFigure index_of(const CheckedFigure& coarse, double estimate) {
  CheckedFigure figure;
  figure.figure = coarse.figure;
  figure.unit = "index";
  figure.target = 1.0;
  figure.result = estimate / (coarse.target - coarse.result);
  figure.error = figure.result - 1.0;
  figure.tolerance = largest_index - 1.0;
  figure.passed = figure.result >= least_index && figure.result <= largest_index;
  figure.source = "estimated over true error of the mesh; 0.7 to 1.5";
  return figure;
}

}  // namespace

std::vector<CaseResult> run_mesh_estimates(const std::string& directory) {
  std::vector<CaseResult> results;
  for (const std::string& path : case_files(directory)) {
    const CaseResult coarse = run_case(path, mesh_factor, 0);
    const CaseResult finer = run_case(path, mesh_factor, 1), finest = run_case(path, mesh_factor, 2);
    CaseResult result{coarse.id, "effectivity of the mesh error", coarse.unknowns, {}};
    for (std::size_t i = 0; i < coarse.figures.size(); ++i) {
      const CheckedFigure& figure = coarse.figures[i];
      const bool is_exact = figure.tolerance <= largest_tolerance && figure.tolerance > largest_rounding;
      if (!is_exact || std::abs(figure.error) < least_error) continue;
      const double first = finer.figures[i].result - figure.result;
      const double second = finest.figures[i].result - finer.figures[i].result;
      result.figures.push_back(index_of(figure, error_left(first, second, MeshSettings().degree)));
    }
    if (!result.figures.empty()) results.push_back(std::move(result));
  }
  return results;
}

}  // namespace spindle_twin::fem_offline

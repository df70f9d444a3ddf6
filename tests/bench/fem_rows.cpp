#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "fem_offline/solve/thermal_system.hpp"
#include "fem_offline/sparse/cholesky.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "tests/bench/bare_cholmod.hpp"
#include "tests/bench/rows.hpp"

namespace spindle_twin::bench {
namespace {

using fem_offline::AffineModel;

/// What one mesh took, seconds.
struct FeTimes {
  double mesh_s = 0.0;
  double assembly_s = 0.0;  ///< unknowns, contacts and assembly of all affine terms
  double sum_s = 0.0;       ///< common pattern of the terms, and their sum
  double new_sum_s = 0.0;   ///< the sum alone
  double analysed_s = 0.0;  ///< analysis and factorisation
  double factor_s = 0.0;    ///< factorisation with what is analysed
  double solve_s = 0.0;
  double step_s = 0.0;  ///< transient
  double bare_analysis_s = 0.0, bare_factor_s = 0.0, bare_solve_s = 0.0;
};

struct Size {
  double unknowns = 0.0;
  FeTimes took;
  double whole_s() const { return took.mesh_s + took.assembly_s + took.sum_s + took.analysed_s + took.solve_s; }
};

/// Least squares of log time over log size.
double growth_exponent(const std::vector<Size>& sizes) {
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  const auto count = static_cast<double>(sizes.size());
  for (const Size& size : sizes) {
    const double lx = std::log(size.unknowns), ly = std::log(size.whole_s());
    x += lx, y += ly, xx += lx * lx, xy += lx * ly;
  }
  return (count * xy - x * y) / (count * xx - x * x);
}

double seconds_of_step(const AffineModel& affine, const rom::BoundaryValues& values) {
  // Past the short steps after the start, so that one step length is left.
  constexpr double settle_s = 300.0, step_s = 10.0;
  constexpr int steps = 10;
  fem_offline::FeStepper stepper(affine);
  stepper.set_uniform_temperature(values.environment_K[0]);
  stepper.advance(settle_s, step_s, values);
  return thread_seconds(1, [&] { stepper.advance(steps * step_s, step_s, values); }) / steps;
}

Size measure_size(double element_size_mm) {
  const int repeats = element_size_mm > 0.9 ? 5 : 3;
  std::optional<fem_offline::FeModel> model;
  FeTimes took;
  const double model_s = thread_seconds(repeats, [&] { model.emplace(reference_model(element_size_mm, true)); });
  took.mesh_s = thread_seconds(repeats, [&] { fem_offline::mesh_section(model->description(), model->section()); });
  took.assembly_s = model_s - took.mesh_s;
  const AffineModel& affine = model->affine();
  rom::BoundaryValues values = rom::make_boundary_values(affine.boundaries);
  rom::evaluate_boundaries(affine.boundaries, affine.boundaries.operating, rom::no_correction(affine.boundaries),
                           values);

  std::optional<fem_offline::ThermalSystem> system;
  took.sum_s = thread_seconds(repeats, [&] { system.emplace(affine); });
  took.new_sum_s = thread_seconds(repeats, [&] { system->set_conductances(values.conductance_W_per_m2K); });
  took.sum_s += took.new_sum_s;
  const SparseMatrix& lower = system->conduction_lower();
  std::optional<fem_offline::CholeskyFactor> factor, again;
  took.analysed_s = thread_seconds(repeats, [&] { factor.emplace(lower); });
  took.factor_s = thread_seconds(repeats, [&] { again.emplace(factor->analysis(), lower); });
  const Eigen::VectorXd load_W = system->load_W(values, values.environment_K[0]);
  Eigen::VectorXd rise_K;
  took.solve_s = thread_seconds(repeats, [&] { factor->solve(load_W, rise_K); });

  BareCholmod bare;
  took.bare_analysis_s = thread_seconds(repeats, [&] { bare.analyse(lower); });
  took.bare_factor_s = thread_seconds(repeats, [&] { bare.factorise(lower); });
  took.bare_solve_s = thread_seconds(repeats, [&] { bare.solve(load_W); });
  took.step_s = seconds_of_step(affine, values);
  return {static_cast<double>(lower.rows()), took};
}

/// `detail`: sizes between the smallest and the largest.
void print_size(const RowPrinter& printer, const Size& size, bool detail) {
  const FeTimes& took = size.took;
  const double bare_s = took.bare_analysis_s + took.bare_factor_s;
  const std::string at = with_commas(std::lround(size.unknowns)) + " unknowns: ";
  const char* both = "bare CHOLMOD: analysis and factorisation";
  const auto print = [&](const std::string& name, double ours_s, const char* other, double other_s, const char* means,
                         std::optional<double> goal, bool is_detail) {
    printer.print({.group = "FE model",
                   .name = at + name,
                   .ours_s = ours_s,
                   .other_name = other,
                   .other_s = other_s,
                   .means = means,
                   .goal = goal,
                   .detail = is_detail});
  };
  print("assembly, sum, factorisation", took.assembly_s + took.sum_s + took.analysed_s, both, bare_s,
        "From the mesh to a factor; the bare one is given the matrix.", 3.0, detail);
  print("of which assembly of all affine terms", took.assembly_s, both, bare_s, "", {}, true);
  print("of which the terms' common pattern and their sum", took.sum_s, both, bare_s, "", {}, true);
  print("of which analysis and factorisation", took.analysed_s, both, bare_s, "", {}, true);
  print("mesh generation, not in it", took.mesh_s, both, bare_s, "", {}, true);
  print("new conductances", took.new_sum_s + took.factor_s, "bare CHOLMOD: factorisation", took.bare_factor_s,
        "Sum and factorisation: what another film or joint costs once the pattern stands.", 3.0, detail);
  print("one transient step, order 2", took.step_s, "two bare back-substitutions", 2.0 * took.bare_solve_s,
        "Its two solutions, and all that stands around them.", {}, detail);
}

}  // namespace

double step_seconds(const std::string& spindle_path) {
  constexpr double step_s = 0.5;
  constexpr int steps = 100, repeats = 5;
  const fem_offline::FeModel model = fem_offline::build_fe_model(spindle_path);
  const rom::Boundaries& boundaries = model.affine().boundaries;
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, boundaries.operating, rom::no_correction(boundaries), values);
  fem_offline::FeStepper stepper(model.affine());
  stepper.advance(step_s, step_s, values);
  return thread_seconds(repeats, [&] { stepper.advance(steps * step_s, step_s, values); }) / steps;
}

void print_fem_rows(const RowPrinter& printer) {
  std::vector<Size> sizes;
  for (const double element_size_mm : {4.6, 2.0, 1.0, 0.46}) {
    sizes.push_back(measure_size(element_size_mm));
    print_size(printer, sizes.back(), sizes.size() == 2 || sizes.size() == 3);
  }
  const Size &smallest = sizes.front(), &largest = sizes.back();
  const double growth = largest.unknowns / smallest.unknowns;
  constexpr double goal_exponent = 1.4;
  char exponent[16];
  std::snprintf(exponent, sizeof exponent, "%.2f", growth_exponent(sizes));
  printer.print({.group = "FE model",
                 .name = "description to steady state, " + with_commas(std::lround(largest.unknowns)) + " unknowns",
                 .ours_s = largest.whole_s(),
                 .other_name = with_commas(std::lround(smallest.unknowns)) + " unknowns, in proportion",
                 .other_s = smallest.whole_s() * growth,
                 .means = std::string("Growth with size: over four sizes time rises with unknowns to the power of ") +
                          exponent + ".",
                 .goal = std::pow(growth, goal_exponent - 1.0)});
}

}  // namespace spindle_twin::bench

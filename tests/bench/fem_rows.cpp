#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "fem_offline/solve/thermal_system.hpp"
#include "fem_offline/sparse/cholesky.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "tests/bench/rows.hpp"

namespace spindle_twin::bench {
namespace {

using fem_offline::AffineModel;
using fem_offline::SparseMatrix;

/// CHOLMOD as it comes: its own choice of ordering and method.
class BareCholmod {
 public:
  BareCholmod() { cholmod_start(&common_); }
  ~BareCholmod() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_free_dense(&solution_, &common_);
    cholmod_free_dense(&workspace_y_, &common_);
    cholmod_free_dense(&workspace_e_, &common_);
    cholmod_finish(&common_);
  }
  BareCholmod(const BareCholmod&) = delete;
  BareCholmod& operator=(const BareCholmod&) = delete;

  void analyse(const SparseMatrix& lower) {
    cholmod_free_factor(&factor_, &common_);
    cholmod_sparse view = view_of(lower);
    factor_ = cholmod_analyze(&view, &common_);
  }
  void factorise(const SparseMatrix& lower) {
    cholmod_sparse view = view_of(lower);
    cholmod_factorize(&view, factor_, &common_);
  }
  void solve(const Eigen::VectorXd& load) {
    cholmod_dense given{};
    given.nrow = given.nzmax = given.d = static_cast<std::size_t>(load.size());
    given.ncol = 1;
    given.x = const_cast<double*>(load.data());
    given.xtype = CHOLMOD_REAL;
    given.dtype = CHOLMOD_DOUBLE;
    cholmod_solve2(CHOLMOD_A, factor_, &given, nullptr, &solution_, nullptr, &workspace_y_, &workspace_e_, &common_);
  }

 private:
  static cholmod_sparse view_of(const SparseMatrix& lower) {
    cholmod_sparse view{};
    view.nrow = static_cast<std::size_t>(lower.rows());
    view.ncol = static_cast<std::size_t>(lower.cols());
    view.nzmax = static_cast<std::size_t>(lower.nonZeros());
    view.p = const_cast<int*>(lower.outerIndexPtr());
    view.i = const_cast<int*>(lower.innerIndexPtr());
    view.x = const_cast<double*>(lower.valuePtr());
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    return view;
  }

  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* solution_ = nullptr;
  cholmod_dense* workspace_y_ = nullptr;
  cholmod_dense* workspace_e_ = nullptr;
};

struct Size {
  double unknowns = 0.0;
  double whole_s = 0.0;  ///< mesh, assembly, factors, solution
};

double slope(const Size& from, const Size& to) {
  return std::log(to.whole_s / from.whole_s) / std::log(to.unknowns / from.unknowns);
}

/// Least squares of log time over log size.
double growth_exponent(const std::vector<Size>& sizes) {
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  const auto count = static_cast<double>(sizes.size());
  for (const Size& size : sizes) {
    const double lx = std::log(size.unknowns), ly = std::log(size.whole_s);
    x += lx, y += ly, xx += lx * lx, xy += lx * ly;
  }
  return (count * xy - x * y) / (count * xx - x * x);
}

Size measure_size(double element_size_mm) {
  const int repeats = element_size_mm > 0.9 ? 5 : 3;
  std::optional<fem_offline::FeModel> model;
  const double model_s = thread_seconds(repeats, [&] { model.emplace(reference_model(element_size_mm, true)); });
  const double mesh_s =
      thread_seconds(repeats, [&] { fem_offline::mesh_section(model->description(), model->section()); });
  const double assembly_s = model_s - mesh_s;
  const AffineModel& affine = model->affine();
  rom::BoundaryValues values = rom::make_boundary_values(affine.boundaries);
  rom::evaluate_boundaries(affine.boundaries, affine.boundaries.operating, rom::no_correction(affine.boundaries),
                           values);

  std::optional<fem_offline::ThermalSystem> system;
  const double pattern_s = thread_seconds(repeats, [&] { system.emplace(affine); });
  const double sum_s = thread_seconds(repeats, [&] { system->set_conductances(values.conductance_W_per_m2K); });
  const SparseMatrix& lower = system->conduction_lower();
  std::optional<fem_offline::CholeskyFactor> factor, again;
  const double analysed_s = thread_seconds(repeats, [&] { factor.emplace(lower); });
  const double factor_s = thread_seconds(repeats, [&] { again.emplace(*factor, lower); });
  const double datum_K = values.environment_K[0];
  const Eigen::VectorXd load_W = system->load_W(values, datum_K);
  Eigen::VectorXd rise_K;
  const double solve_s = thread_seconds(repeats, [&] { factor->solve(load_W, rise_K); });

  BareCholmod bare;
  const double bare_analysis_s = thread_seconds(repeats, [&] { bare.analyse(lower); });
  const double bare_factor_s = thread_seconds(repeats, [&] { bare.factorise(lower); });
  const double bare_solve_s = thread_seconds(3, [&] { bare.solve(load_W); });

  fem_offline::FeStepper stepper(affine);
  // Past the short steps after the start, so that one step length is left.
  constexpr double settle_s = 300.0, step_s = 10.0, steps = 10.0;
  stepper.set_uniform_temperature(datum_K);
  stepper.advance(settle_s, step_s, values);
  const double ten_steps_s = thread_seconds(1, [&] { stepper.advance(steps * step_s, step_s, values); });

  std::printf("%.0f unknowns (element size %g mm)\n", static_cast<double>(lower.rows()), element_size_mm);
  const double bare_s = bare_analysis_s + bare_factor_s;
  print_row("bare CHOLMOD: analysis and factorisation", bare_s, "s");
  print_row("assembly of all affine terms, their sum, analysis, factorisation / bare",
            (assembly_s + pattern_s + sum_s + analysed_s) / bare_s, "x", "goal 3");
  print_row("  of which unknowns, contacts and assembly of all terms / bare", assembly_s / bare_s, "x");
  print_row("  of which common pattern of the terms, and their sum / bare", (pattern_s + sum_s) / bare_s, "x");
  print_row("  of which analysis and factorisation / bare", analysed_s / bare_s, "x");
  print_row("mesh generation (not in it) / bare", mesh_s / bare_s, "x");
  print_row("new conductances: sum and factorisation / bare factorisation", (sum_s + factor_s) / bare_factor_s, "x",
            "goal 3");
  print_row("transient step (2 solves) / 2 bare back-substitutions", ten_steps_s / steps / (2.0 * bare_solve_s), "x");
  return {static_cast<double>(lower.rows()), model_s + pattern_s + sum_s + analysed_s + solve_s};
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

void print_fem_rows() {
  std::vector<Size> sizes;
  for (const double element_size_mm : {4.6, 2.0, 1.0, 0.46}) sizes.push_back(measure_size(element_size_mm));
  std::printf("growth of mesh, assembly, factorisation and solution\n");
  for (std::size_t i = 1; i < sizes.size(); ++i) {
    print_row("  exponent from " + std::to_string(std::lround(sizes[i - 1].unknowns)) + " to " +
                  std::to_string(std::lround(sizes[i].unknowns)) + " unknowns",
              slope(sizes[i - 1], sizes[i]), "");
  }
  print_row("exponent over all sizes", growth_exponent(sizes), "", "goal 1.4");
}

}  // namespace spindle_twin::bench

#include <string>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/thermal_system.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "tests/bench/bare_cholmod.hpp"
#include "tests/bench/rows.hpp"

namespace spindle_twin::bench {

FactorCost factor_cost(const std::string& spindle_path) {
  constexpr int repeats = 20;
  const fem_offline::FeModel model = fem_offline::build_fe_model(spindle_path);
  const fem_offline::AffineModel& affine = model.affine();
  rom::BoundaryValues values = rom::make_boundary_values(affine.boundaries);
  rom::evaluate_boundaries(affine.boundaries, affine.boundaries.operating, rom::no_correction(affine.boundaries),
                           values);
  fem_offline::ThermalSystem system(affine);
  system.set_conductances(values.conductance_W_per_m2K);
  const SparseMatrix& lower = system.conduction_lower();
  const Eigen::VectorXd load_W = system.load_W(values, values.environment_K[0]);
  BareCholmod bare;
  bare.analyse(lower);
  FactorCost cost{.unknowns = static_cast<long>(lower.rows())};
  cost.factor_s = thread_seconds(repeats, [&] { bare.factorise(lower); });
  cost.bytes = static_cast<double>(bare.factor_bytes());
  cost.solve_s = thread_seconds(repeats, [&] { bare.solve(load_W); });
  return cost;
}

}  // namespace spindle_twin::bench

// Fields of the FE model behind jumps, among its snapshots.
#include "fem_offline/reduce/full_histories.hpp"

#include <gtest/gtest.h>

#include <iostream>

#include "coarse_milling.hpp"
#include "fem_offline/reduce/basis.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_full_histories_test {

const AffineModel& milling() {
  static const FeModel model = coarse_milling(0.01);
  return model.affine();
}

/// The largest that the basis leaves of fields behind other jumps, K.
double left_over_K(int sets, int histories) {
  ReduceOptions options;
  options.full_sets = sets;
  options.full_histories = histories;
  options.rich_states = 400;
  options.rich_states_per_body = 0;
  Loads loads = make_loads(milling(), options.box.speed_high_rpm, options.box.load_high);
  const Eigen::MatrixXd basis = full_snapshot_basis(milling(), loads, options, {}).columns;
  options.seed = 99;
  AnalysedSystem matrices(milling());
  double worst_K = 0.0;
  for (std::uint32_t set = 0; set < 6; ++set) {
    Eigen::MatrixXd fields = full_history(
        milling(), matrices, random_history(milling().boundaries, options, StreamPurpose::full_histories, set));
    fields -= basis * (basis.transpose() * fields).eval();
    worst_K = std::max(worst_K, fields.cwiseAbs().maxCoeff());
  }
  return worst_K;
}

/// A wall that warmed up without coolant and then meets it: no solution for a single load looks like that.
TEST(FullHistories, bring_fields_behind_jumps_into_the_basis_where_more_single_loads_do_not) {
  const double with_K = left_over_K(20, 40), without_K = left_over_K(40, 0);
  std::cout << "left of fields behind other jumps: " << with_K << " K, of the same without histories " << without_K
            << " K\n";
  EXPECT_LT(with_K, 0.5 * without_K);
}

}  // namespace reduce_full_histories_test
}  // namespace spindle_twin::fem_offline

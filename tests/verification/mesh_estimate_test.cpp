// Whether the estimate of the mesh error is the mesh error.
#include <gtest/gtest.h>

#include <set>

#include "fem_offline/reduce/mesh_error.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "fem_offline/verify_cases/fem_case.hpp"
#include "tests/verification/nominal.hpp"

namespace spindle_twin::fem_offline {
namespace mesh_estimate_test {

constexpr double least_index = 0.7, largest_index = 1.5;

TEST(MeshEstimate, is_the_error_of_cases_with_known_answers) {
  std::set<std::string> cases;
  for (const CaseResult& result : run_mesh_estimates(default_cases_directory())) {
    cases.insert(result.id);
    for (const CheckedFigure& figure : result.figures) {
      EXPECT_TRUE(figure.passed) << result.id << ", " << figure.figure << ": " << figure.result;
    }
  }
  EXPECT_GE(cases.size(), 5U);
  EXPECT_TRUE(cases.contains("square_bend"));  // whose answer is of order 4/3
}

/// The reference spindle with elements of 4 mm everywhere, as its file had them until corners were graded.
Spindle even_reference() {
  Spindle spindle = read_spindle(spindle_file("reference"));
  spindle.mesh.corner_size_m.reset();
  return spindle;
}

double steady_nose_m(const Spindle& spindle) {
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd outputs =
      fe_outputs(model.affine(), solve_steady(model.affine(), nominal_values(model.affine())));
  return outputs[output_layout(model.affine()).deformations_at()];
}

/// The limit from elements of degree 3, and of degree 2 cut in four, both down to 0.02 mm at the corners.
TEST(MeshEstimate, is_the_error_of_the_reference_nose_with_and_without_graded_corners) {
  Spindle fine = even_reference();
  fine.mesh.corner_size_m = 2e-5;
  Spindle cubic = fine, halved = fine;
  cubic.mesh.degree = 3;
  halved.mesh.halvings = 1;
  const double limit_m = steady_nose_m(cubic);
  ASSERT_NEAR(limit_m, steady_nose_m(halved), 2e-10);
  Spindle even = even_reference(), graded = even_reference();
  graded.mesh.corner_size_m = 5e-4;
  for (const Spindle& spindle : {even, graded}) {
    const FeModel model(spindle, build_section(spindle));
    const double estimate_m = steady_mesh_error(model)[output_layout(model.affine()).deformations_at()];
    const double error_m = limit_m - steady_nose_m(spindle);
    EXPECT_GT(estimate_m / error_m, least_index) << estimate_m << ' ' << error_m;
    EXPECT_LT(estimate_m / error_m, largest_index) << estimate_m << ' ' << error_m;
  }
}

}  // namespace mesh_estimate_test
}  // namespace spindle_twin::fem_offline

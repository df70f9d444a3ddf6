#include "fem_offline/reduce/choose_mesh.hpp"

#include <gtest/gtest.h>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/mesh_error.hpp"
#include "fem_offline/reduce/trajectory.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_choose_mesh_test {

Spindle coarse_spindle() {
  Spindle spindle = read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/jacket_circuit.toml");
  spindle.mesh.corner_size_m.reset();
  return spindle;
}

TEST(MeshChoice, has_less_error_than_wanted_by_the_estimate_too) {
  constexpr double wanted_m = 1e-8;
  const MeshChoice choice = choose_mesh(coarse_spindle(), wanted_m, 5.0, {});
  ASSERT_TRUE(choice.reached);
  EXPECT_GT(choice.meshes.front().error_m, wanted_m);
  EXPECT_LT(choice.meshes.back().error_m, wanted_m);
  EXPECT_LT(choice.meshes.back().largest_step_m, wanted_m);
  for (std::size_t i = 1; i < choice.meshes.size(); ++i) {
    EXPECT_FALSE(choice.meshes[i].finer.empty());
    EXPECT_GT(choice.meshes[i].unknowns, choice.meshes[i - 1].unknowns);
  }
  const FeModel model(choice.spindle, build_section(choice.spindle));
  EXPECT_EQ(model.affine().places.size(), choice.meshes.back().unknowns);
  const OutputLayout layout = output_layout(model.affine());
  const Eigen::VectorXd errors = steady_mesh_error(model);
  EXPECT_LT(errors.segment(layout.deformations_at(), layout.deformations).cwiseAbs().maxCoeff(), 1.5 * wanted_m);
}

TEST(MeshChoice, stops_at_the_unknowns_allowed) {
  const MeshChoice choice = choose_mesh(coarse_spindle(), 1e-12, 1.3, {});
  EXPECT_FALSE(choice.reached);
  EXPECT_LE(static_cast<double>(choice.meshes.back().unknowns),
            1.3 * static_cast<double>(choice.meshes.front().unknowns));
}

TEST(MeshChoice, needs_a_deformation) {
  Spindle spindle = coarse_spindle();
  spindle.deformations.clear();
  EXPECT_THROW(choose_mesh(spindle, 1e-8, 2.0, {}), rom::InputError);
}

}  // namespace reduce_choose_mesh_test
}  // namespace spindle_twin::fem_offline

#include <gtest/gtest.h>

#include "tests/correction/paper/one_node.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace paper_no_heap_test {

TEST(PaperCorrection, step_never_calls_the_heap) {
  PaperOptions options;
  options.groups = {{"front", {0, 1, 2}, {0}}, {"rear", {3, 4, 5}, {1}}};
  Loop loop(375.0, 2.16, options, 2);
  const Eigen::VectorXd model_K = Eigen::VectorXd::Constant(6, ambient_K + 4.0);
  const Eigen::VectorXd measured_K = Eigen::VectorXd::Constant(6, ambient_K + 2.0);
  const Eigen::VectorXd nodes_K = Eigen::VectorXd::Constant(2, ambient_K + 4.0);
  const Eigen::VectorXd cold_K = Eigen::VectorXd::Constant(2, ambient_K);
  loop.correction.reset(0.0, cold_K, loop.operating);
  bool rescaled = false;
  const long before = rom::tests::heap_calls();
  for (int second = 0; second <= 400; ++second) {
    const double time_s = second;
    rescaled |=
        loop.correction.step({time_s, measured_K, loop.valid, model_K, nodes_K, loop.operating}, 1.0).state_rescaled;
  }
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
  EXPECT_TRUE(rescaled);
}

}  // namespace paper_no_heap_test
}  // namespace spindle_twin::correction::test

#include "rom/integrate/time_constants.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rom/integrate/output_uncertainty.hpp"
#include "tests/rom/shared_operator.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace time_constants_test {

TEST(TimeConstants, of_a_node_is_its_capacity_over_what_cools_it_and_without_end_where_nothing_does) {
  const auto shared = share(make_single_node());
  EXPECT_NEAR(time_constants_s(*shared, Eigen::VectorXd::Constant(1, 50.0))[0], 1000.0 / 25.0, 1e-9);
  EXPECT_TRUE(std::isinf(time_constants_s(*shared, Eigen::VectorXd::Zero(1))[0]));
}

/// An insulated network keeps its heat for ever, and everything else in it comes to rest.
TEST(TimeConstants, an_insulated_network_has_one_without_end) {
  const Network network = make_synthetic_network({2, 2, 2, false}, 8);
  const auto shared = share(network);
  Eigen::VectorXd conductance_W_per_m2K(shared->conductances());
  for (Eigen::Index j = 0; j < conductance_W_per_m2K.size(); ++j) {
    conductance_W_per_m2K[j] = network.boundaries.conductances[static_cast<std::size_t>(j)].nominal_W_per_m2K;
  }
  const Eigen::VectorXd found_s = time_constants_s(*shared, conductance_W_per_m2K);
  EXPECT_EQ(found_s.size(), shared->nodes());
  EXPECT_EQ(found_s.array().isInf().count(), 1);
  EXPECT_GT(found_s.minCoeff(), 0.0);
}

TEST(OutputUncertainty, is_that_of_the_whole_certificate_where_outputs_have_none_of_their_own_from_one_case_on) {
  Network network = make_single_node();
  network.certificate.worst = {0.4, 6.0, 0.8};
  network.certificate.cases = 0;
  EXPECT_TRUE(std::isnan(output_uncertainty(network).key_points_K[0])) << "nobody measured any";
  network.certificate.cases = 1;
  OutputUncertainty sigma = output_uncertainty(network);
  EXPECT_EQ(sigma.key_points_K[0], 0.2);
  EXPECT_EQ(sigma.part_means_K[0], 0.4);
  EXPECT_EQ(sigma.part_maxima_K[0], 0.4);
  EXPECT_NEAR(sigma.deformations_m[0], 3e-6, 1e-18);
  network.certificate.key_points_K = {{6.0, 5.0, 4.0, 0.0}};
  EXPECT_NEAR(output_uncertainty(network).key_points_K[0], 5.0, 1e-15) << "half the worst, and the mesh";
  network.certificate.key_points_K = {{6.0, 5.0, 4.0, 16.0}};
  EXPECT_NEAR(output_uncertainty(network).key_points_K[0], std::hypot(8.0, 4.0), 1e-15) << "the limit in its place";
}

}  // namespace time_constants_test
}  // namespace spindle_twin::rom::tests

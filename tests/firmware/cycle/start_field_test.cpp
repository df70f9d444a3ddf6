#include "firmware/cycle/start_field.hpp"

#include <gtest/gtest.h>

#include <cstddef>

#include "firmware/cycle/publish.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace cycle_start_field_test {

TEST(StartField, has_the_key_points_and_lies_between_them) {
  const rom::Network network = tests::small_network();
  Snapshot said = first_snapshot(network);
  EXPECT_EQ(start_field(network, said).size(), 0) << "nothing is known";
  for (std::size_t k = 0; k < 3; ++k) said.predicted_K[k] = 310.0 - 5.0 * static_cast<double>(k);
  Eigen::VectorXd field_K = start_field(network, said);
  ASSERT_EQ(field_K.size(), 5);
  for (Eigen::Index k = 0; k < 3; ++k) EXPECT_NEAR(field_K[2 + k], said.predicted_K[static_cast<std::size_t>(k)], 2e-3);
  EXPECT_NEAR(field_K[0], 310.0, 2e-3) << "no heat flows to what has no key point";
  EXPECT_NEAR(field_K[1], 310.0, 2e-3);
  said.part_maximum_K[0] = 320.0;
  said.part_maximum_K[1] = 315.0;
  field_K = start_field(network, said);
  EXPECT_NEAR(field_K[0], 320.0, 0.1);
  EXPECT_NEAR(field_K[1], 315.0, 0.1);
}

TEST(StartField, gives_nothing_to_the_surroundings_whatever_number_they_have) {
  for (const int environment : {0, 1}) {
    rom::Network network = tests::small_network();
    for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
      if (network.boundaries.conductances[j].environment != environment) continue;
      network.factors_m[j].setZero();
      network.factors_m[j](0, 0) = 0.5;  // the rotor's, which has no key point
    }
    Snapshot said = first_snapshot(network);
    for (std::size_t k = 0; k < 3; ++k) said.predicted_K[k] = 310.0 - 5.0 * static_cast<double>(k);
    EXPECT_NEAR(start_field(network, said)[0], 310.0, 2e-3) << "environment " << environment;
  }
}

TEST(StartField, what_nothing_connects_has_the_mean_of_what_is_known) {
  rom::Network network = tests::small_network();
  network.factors_m[0].setZero();  // the rotor's contact
  Snapshot said = first_snapshot(network);
  for (std::size_t k = 0; k < 3; ++k) said.predicted_K[k] = 310.0 - 5.0 * static_cast<double>(k);
  EXPECT_NEAR(start_field(network, said)[0], 305.0, 1e-3);
  said.predicted_K[1] = not_a_value;
  said.predicted_K[2] = 302.0;
  EXPECT_NEAR(start_field(network, said)[0], 306.0, 1e-3);
  said.part_maximum_K[0] = 320.0;
  EXPECT_NEAR(start_field(network, said)[0], 320.0, 1e-3);
}

}  // namespace cycle_start_field_test
}  // namespace spindle_twin::firmware

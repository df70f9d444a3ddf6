#include "host_tools/calibrate/leave_out_spikes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::host_tools {
namespace calibrate_leave_out_spikes_test {

constexpr double um = 1e-6;

/// An hour, a reading each ten seconds, a growth of 30 um with a step of the speed in the middle; noise 1 um, 0.05 K.
struct Hour {
  Hour() {
    std::mt19937_64 random(7);
    std::normal_distribution<double> noise;
    const auto sensors = static_cast<Eigen::Index>(network.key_points.size());
    test.measured_K = Eigen::MatrixXd(361, sensors);
    test.deformation_m = Eigen::MatrixXd(361, static_cast<Eigen::Index>(network.deformations.size()));
    for (Eigen::Index r = 0; r < 361; ++r) {
      const double time_s = 10.0 * static_cast<double>(r);
      test.time_s.push_back(time_s);
      const double course = time_s < 1800.0 ? 1.0 - std::exp(-time_s / 600.0) : 1.5 - 0.5 * time_s / 1800.0;
      for (Eigen::Index k = 0; k < sensors; ++k) test.measured_K(r, k) = 295.0 + 10.0 * course + 0.05 * noise(random);
      test.deformation_m.row(r).setConstant(30.0 * um * course + um * noise(random));
    }
  }
  rom::Network network = tests::small_network();
  correction::ThermalTest test;
};

TEST(LeaveOutSpikes, nothing_is_taken_from_noise_steps_and_gaps) {
  Hour hour;
  hour.test.deformation_m.col(0).tail(100).array() += 40.0 * um;
  hour.test.measured_K.col(0).tail(50).array() -= 3.0;
  hour.test.measured_K.col(1).segment(100, 60).setConstant(std::nan(""));
  EXPECT_TRUE(leave_out_spikes(hour.network, um, hour.test).empty());
}

TEST(LeaveOutSpikes, readings_that_stand_alone_go_and_are_counted_with_the_time_of_the_first) {
  Hour hour;
  for (const Eigen::Index row : {20, 21, 200}) hour.test.deformation_m(row, 0) += 500.0 * um;
  hour.test.measured_K(300, 1) -= 2.0;
  const Hour before = hour;
  const std::vector<Spikes> spikes = leave_out_spikes(hour.network, um, hour.test);
  ASSERT_EQ(spikes.size(), 2U);
  EXPECT_EQ(spikes[0].channel, hour.network.key_points[1].name);
  EXPECT_EQ(spikes[0].readings, 1);
  EXPECT_EQ(spikes[0].first_s, 3000.0);
  EXPECT_EQ(spikes[1].channel, hour.network.deformations[0].name);
  EXPECT_EQ(spikes[1].readings, 3);
  EXPECT_EQ(spikes[1].first_s, 200.0);
  int gone = 0;
  for (Eigen::Index r = 0; r < hour.test.deformation_m.rows(); ++r) {
    gone += std::isnan(hour.test.deformation_m(r, 0)) ? 1 : 0;
    if (!std::isnan(hour.test.deformation_m(r, 0))) {
      EXPECT_EQ(hour.test.deformation_m(r, 0), before.test.deformation_m(r, 0));
    }
  }
  EXPECT_EQ(gone, 3);
}

}  // namespace calibrate_leave_out_spikes_test
}  // namespace spindle_twin::host_tools

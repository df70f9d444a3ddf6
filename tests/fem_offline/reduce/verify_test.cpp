#include "fem_offline/reduce/verify.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem_offline/reduce/random_history.hpp"
#include "grid_model.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_verify_test {

const rom::Network& verified_network() {
  static const rom::Network built = [] {
    ReduceOptions options;
    options.nodes = 60;
    options.full_sets = 40;
    options.full_histories = 40;
    options.rich_sets = 40;
    options.rich_states = 220;
    return reduce_model(make_grid_model(), options);
  }();
  return built;
}

TEST(DriveCase, stays_in_the_box) {
  const rom::Boundaries boundaries = make_grid_model().boundaries;
  const ParameterBox box;
  double smallest_contact = 1.0, largest_contact = 1.0, fastest_rpm = 0.0;
  for (std::uint32_t index = 0; index < 200; ++index) {
    const DriveCase drawn = random_case(boundaries, 5, index);
    for (Eigen::Index j = 0; j < drawn.factors.conductance.size(); ++j) {
      const bool contact = boundaries.conductances[static_cast<std::size_t>(j)].kind == rom::ConductanceKind::contact;
      const double factor = drawn.factors.conductance[j];
      ASSERT_GE(factor, contact ? box.contact_low : box.film_low);
      ASSERT_LE(factor, contact ? box.contact_high : box.film_high);
      if (contact) smallest_contact = std::min(smallest_contact, factor);
      if (contact) largest_contact = std::max(largest_contact, factor);
    }
    double end_s = 0.0;
    for (const HeldInterval& interval : drawn.intervals) {
      end_s += interval.duration_s;
      fastest_rpm = std::max(fastest_rpm, interval.state.speed_rpm);
      ASSERT_GT(interval.duration_s, 0.0);
      ASSERT_LE(interval.duration_s, longest_interval_s);
      ASSERT_GE(interval.state.speed_rpm, 0.0);
      ASSERT_LE(interval.state.speed_rpm, box.speed_high_rpm);
      ASSERT_GE(interval.state.load, 0.0);
      ASSERT_LE(interval.state.load, box.load_high);
      // Five kelvin of spread and two hours of drift at 6 K/h.
      ASSERT_LE((interval.state.environment_K - boundaries.operating.environment_K).cwiseAbs().maxCoeff(), 17.1);
    }
    ASSERT_GE(end_s, 3600.0);
    ASSERT_LE(end_s, 7200.0 + longest_interval_s);
  }
  EXPECT_LT(smallest_contact, 0.12);
  EXPECT_GT(largest_contact, 8.5);
  EXPECT_GT(fastest_rpm, 23000.0);
}

TEST(DriveCase, depends_on_seed_and_index_alone) {
  const rom::Boundaries boundaries = make_grid_model().boundaries;
  const DriveCase first = random_case(boundaries, 5, 3), again = random_case(boundaries, 5, 3);
  EXPECT_EQ(first.factors.conductance, again.factors.conductance);
  EXPECT_EQ(first.intervals.size(), again.intervals.size());
  EXPECT_NE(first.factors.conductance, random_case(boundaries, 5, 4).factors.conductance);
  EXPECT_NE(first.factors.conductance, random_case(boundaries, 6, 3).factors.conductance);
}

TEST(DriveCase, drift_is_bounded_in_rate_and_stays_in_the_box) {
  const rom::Boundaries boundaries = make_grid_model().boundaries;
  CaseOptions options;
  options.drift = true;
  double fastest = 0.0, largest_change = 0.0;
  for (std::uint32_t index = 0; index < 20; ++index) {
    const DriveCase drawn = random_case(boundaries, 5, index, options);
    Eigen::ArrayXd before;
    double at_s = 0.0, before_s = 0.0;
    for (const HeldInterval& interval : drawn.intervals) {
      const Eigen::ArrayXd now = interval.conductance_factors.array().log();
      const double middle_s = at_s + 0.5 * interval.duration_s;
      if (before.size() > 0) {
        fastest = std::max(fastest, ((now - before) / (middle_s - before_s)).abs().maxCoeff());
        largest_change = std::max(largest_change, (now - drawn.factors.conductance.array().log()).abs().maxCoeff());
      }
      for (Eigen::Index j = 0; j < now.size(); ++j) {
        const bool contact = boundaries.conductances[static_cast<std::size_t>(j)].kind == rom::ConductanceKind::contact;
        ASSERT_GE(now[j], std::log(contact ? 0.1 : 0.2) - 1e-12);
        ASSERT_LE(now[j], std::log(contact ? 10.0 : 5.0) + 1e-12);
      }
      before = now;
      before_s = middle_s;
      at_s += interval.duration_s;
    }
  }
  EXPECT_LE(fastest, std::log(2.0) / 600.0 * (1.0 + 1e-9));
  EXPECT_GT(fastest, 0.9 * std::log(2.0) / 600.0);
  EXPECT_GT(largest_change, std::log(2.0));
}

TEST(RandomHistory, of_the_search_for_a_size_is_none_of_the_snapshots) {
  const rom::Boundaries boundaries = make_grid_model().boundaries;
  const auto conductances = [&](StreamPurpose purpose) {
    return random_history(boundaries, {}, purpose, 3).states.front().conductance_W_per_m2K;
  };
  EXPECT_NE(conductances(StreamPurpose::size_choice), conductances(StreamPurpose::full_histories));
  EXPECT_EQ(conductances(StreamPurpose::size_choice), conductances(StreamPurpose::size_choice));
}

TEST(Verify, network_follows_the_full_model_through_random_drive_cycles) {
  VerifyOptions options;
  options.cases = 3;
  options.seed = 2;
  const VerifyReport report = verify_network(verified_network(), make_grid_model(), options);
  EXPECT_EQ(report.certificate.cases, 3u);
  EXPECT_EQ(report.cases.size(), 3u);
  EXPECT_GT(report.certificate.worst.key_points_K, 0.0);
  EXPECT_LT(report.certificate.worst.key_points_K, 0.2);
  EXPECT_LT(report.certificate.worst.part_max_K, 1.0);
  EXPECT_LE(report.certificate.median.key_points_K, report.certificate.worst.key_points_K);
  ASSERT_EQ(report.certificate.key_points_K.size(), 3u);
  ASSERT_EQ(report.certificate.part_maxima_K.size(), 6u);
  double worst_K = 0.0;
  for (const rom::OutputError& error : report.certificate.key_points_K) worst_K = std::max(worst_K, error.worst);
  EXPECT_EQ(worst_K, report.certificate.worst.key_points_K);
  EXPECT_DOUBLE_EQ(report.certificate.deformations_m[0].worst, 1e-6 * report.certificate.worst.nose_um);
  EXPECT_EQ(report.certificate.box.contact_high, 10.0);
  EXPECT_EQ(report.certificate.fe_unknowns, 1273u);
}

TEST(Verify, network_follows_the_full_model_while_contacts_and_films_drift) {
  VerifyOptions options;
  options.cases = 1;
  options.seed = 2;
  options.drive.drift = true;
  const VerifyReport report = verify_network(verified_network(), make_grid_model(), options);
  EXPECT_LT(report.certificate.worst.key_points_K, 0.2);
  EXPECT_LT(report.certificate.worst.part_max_K, 1.0);
}

TEST(Verify, sees_a_network_with_a_wrong_source) {
  rom::Network wrong = verified_network();
  wrong.source_distribution.col(3) *= 1.1;
  VerifyOptions options;
  options.cases = 1;
  EXPECT_GT(verify_network(wrong, make_grid_model(), options).certificate.worst.part_max_K, 1.0);
}

TEST(Verify, figures_do_not_depend_on_the_number_of_threads) {
  VerifyOptions options;
  options.cases = 2;
  options.threads = 1;
  const VerifyReport one = verify_network(verified_network(), make_grid_model(), options);
  options.threads = 2;
  const VerifyReport two = verify_network(verified_network(), make_grid_model(), options);
  EXPECT_EQ(one.certificate.worst.key_points_K, two.certificate.worst.key_points_K);
  EXPECT_EQ(one.certificate.worst.nose_um, two.certificate.worst.nose_um);
  EXPECT_EQ(one.certificate.worst.part_max_K, two.certificate.worst.part_max_K);
}

TEST(Verify, refuses_a_network_of_another_model) {
  rom::Network other = verified_network();
  other.key_points.pop_back();
  EXPECT_THROW(verify_network(other, make_grid_model(), {}), std::invalid_argument);
}

TEST(Verify, cases_are_added_as_long_as_a_limit_is_wider_than_wanted_and_no_case_is) {
  VerifyOptions options;
  options.cases = 12;
  options.seed = 77;
  const AffineModel model = make_grid_model();
  const rom::Network network = verified_network();
  const rom::Certificate few = verify_until(network, model, options, {1e3, 1e3, 1e3}).certificate;
  EXPECT_EQ(few.cases, 12U);
  EXPECT_EQ(verify_until(network, model, options, {0.0, 1e3, 1e3}).certificate.cases, 12U) << "no limit can keep it";
  const double kept_K = 1.001 * few.worst.key_points_K;
  ASSERT_LT(kept_K, few.limit.key_points_K);
  const VerifyReport more = verify_until(network, model, options, {kept_K, 1e3, 1e3});
  EXPECT_GT(more.certificate.cases, 12U);
  const bool is_exceeded = more.certificate.worst.key_points_K > kept_K;
  EXPECT_TRUE(is_exceeded || more.certificate.cases == 59U || more.certificate.limit.key_points_K <= kept_K);
  // The same cases as in one go.
  options.cases = more.certificate.cases;
  EXPECT_EQ(verify_network(network, model, options).errors, more.errors);
}

}  // namespace reduce_verify_test
}  // namespace spindle_twin::fem_offline

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "correction/health/isolation.hpp"

namespace spindle_twin::correction::test {
namespace health_isolation_limits_test {

constexpr double begin_s = 1000.0;

/// Updates with evidence as told, at times as told. The first verdict was laid to the model long after the start, at
/// begin_s.
struct Told {
  explicit Told(std::size_t channels, bool first_is_spent = true) : isolation(channels), updates(channels) {
    for (HealthUpdate& update : updates) update = {true, 0.0, 0, 300.0, 1.0};
    judge_at(0.0);
    if (!first_is_spent) return;
    updates[1].evidence = 40.0;
    judge_at(begin_s);
    updates[1].evidence = 0.0;
    judge_at(begin_s);
  }
  Blame judge_at(double time_s) { return isolation.judge(updates, in_doubt, time_s, limits); }
  Blame judge_at(double time_s, const std::vector<double>& evidence) {
    for (std::size_t i = 0; i < evidence.size(); ++i) updates[i].evidence = evidence[i];
    return judge_at(time_s);
  }
  HealthLimits limits;
  Isolation isolation;
  std::vector<HealthUpdate> updates;
  bool in_doubt = false;
};

TEST(Isolation, after_a_verdict_there_is_none_for_two_minutes_and_then_one_again) {
  Told told(4, false);
  const Blame first = told.judge_at(begin_s, {0, 40, 0, 0});
  EXPECT_TRUE(first.first);
  EXPECT_EQ(first.partner, -1);
  EXPECT_TRUE(told.isolation.model_in_doubt()) << "it is laid to the model";
  EXPECT_EQ(told.judge_at(begin_s + 110.0).channel, -1);
  const Blame second = told.judge_at(begin_s + 120.0);
  EXPECT_EQ(second.channel, 1);
  EXPECT_FALSE(second.first);
  EXPECT_EQ(second.partner, -1);
  EXPECT_EQ(told.judge_at(begin_s + 230.0).channel, -1);
  EXPECT_EQ(told.judge_at(begin_s + 240.0).channel, 1);
}

TEST(Isolation, a_verdict_two_hours_after_the_first_is_the_second_still) {
  for (const double after_s : {7200.0, 7210.0}) {
    Told told(4);
    EXPECT_EQ(told.judge_at(begin_s + after_s, {0, 40, 0, 0}).first, after_s > 7200.0);
  }
}

TEST(Isolation, a_suspect_that_is_blamed_is_a_verdict_too_from_which_on_two_minutes_count) {
  Told told(4);
  const Blame opened = told.isolation.judge_suspect(2, 0.1, 0.1, begin_s + 1000.0, told.limits);
  EXPECT_TRUE(opened.offset) << "that it is off nobody knows, but its offset may be the reason";
  EXPECT_FALSE(opened.first);
  EXPECT_EQ(opened.partner, -1);
  EXPECT_EQ(told.judge_at(begin_s + 1110.0, {0, 40, 0, 0}).channel, -1);
  EXPECT_EQ(told.judge_at(begin_s + 1120.0).channel, 1);
  EXPECT_EQ(told.isolation.judge_suspect(3, 0.75, 0.375, begin_s + 2000.0, told.limits).channel, -1)
      << "two deviations";
  const Blame drifts = told.isolation.judge_suspect(3, 0.75, 0.37, begin_s + 2000.0, told.limits);
  EXPECT_EQ(drifts.fault, HealthFault::drift);
  EXPECT_EQ(drifts.partner, -1);
}

TEST(Isolation, where_the_machine_is_an_unlikely_one_even_without_the_channel_it_is_the_model_as_long_as_that_is_so) {
  Told told(4);
  told.updates[1].is_unlikely_without = true;
  for (const double after_s : {1000.0, 1010.0, 1110.0, 1130.0}) {
    EXPECT_EQ(told.judge_at(begin_s + after_s, {0, 40, 0, 0}).channel, -1);
    EXPECT_TRUE(told.isolation.model_in_doubt()) << after_s;
  }
  told.updates[1].is_unlikely_without = false;
  EXPECT_EQ(told.judge_at(begin_s + 1300.0).channel, 1) << "as soon as it is a likely one";
  EXPECT_FALSE(told.isolation.model_in_doubt());
  told.updates[1].is_unlikely_without = true;
  EXPECT_EQ(told.judge_at(begin_s + 1500.0, {0, 29, 0, 0}).channel, -1);
  EXPECT_FALSE(told.isolation.model_in_doubt()) << "nobody is blamed";
}

TEST(Isolation, what_came_slowly_is_implausible_where_it_was_rejected_twice_in_a_row) {
  for (const int rejected : {1, 2}) {
    Told told(4);
    told.updates[1].rejected_in_a_row = rejected;
    told.judge_at(begin_s + 1000.0, {0, 10, 0, 0});
    const Blame blame = told.judge_at(begin_s + 1500.0, {0, 40, 0, 0});
    EXPECT_EQ(blame.fault, rejected == 2 ? HealthFault::implausible : HealthFault::drift);
    EXPECT_EQ(blame.partner, -1);
  }
}

/// A quarter of the limit, 7.5, is calm.
TEST(Isolation, how_fast_evidence_came_is_counted_from_when_it_was_a_quarter_of_the_limit) {
  for (const double before : {7.5, 7.6}) {
    for (const double rise_s : {110.0, 120.0}) {
      Told told(4);
      told.judge_at(begin_s + 1000.0, {0, before, 0, 0});
      const Blame blame = told.judge_at(begin_s + 1000.0 + rise_s, {0, 31, 0, 0});
      EXPECT_EQ(blame.channel, 1);
      EXPECT_EQ(blame.fault, before == 7.5 && rise_s < 120.0 ? HealthFault::implausible : HealthFault::drift);
    }
  }
}

TEST(Isolation, a_lead_of_eight_is_enough_and_less_is_not) {
  for (const double next : {32.0, 32.1}) {
    Told told(6);
    EXPECT_EQ(told.judge_at(begin_s + 1000.0, {0, 40, next, 0, 0, 0}).channel, next == 32.0 ? 1 : -1);
  }
}

TEST(Isolation, channels_with_half_of_the_limit_do_not_put_the_model_in_doubt_and_those_with_more_do) {
  for (const double evidence : {15.0, 15.1}) {
    EXPECT_FALSE(Isolation(4).model_in_doubt()) << "before anything is known";
    Told told(4);
    told.judge_at(begin_s + 1000.0, {0, evidence, evidence, 0});
    EXPECT_EQ(told.isolation.model_in_doubt(), evidence > 15.0);
    told.isolation.note_restart(begin_s + 1010.0);
    EXPECT_FALSE(told.isolation.model_in_doubt()) << "it has begun anew";
  }
}

TEST(Isolation, alone_explains_what_has_more_evidence_than_all_others_together) {
  for (const double third : {8.0, 8.5, 9.0}) {
    Told told(12);
    told.in_doubt = true;
    const Blame blame = told.judge_at(begin_s + 1000.0, {0, 31, 22.5, third, -9, -9, -9, -9, -9, -9, -9, -9});
    EXPECT_EQ(blame.channel, third < 8.5 ? 1 : -1) << third << ": what agrees with all others neither adds nor takes";
  }
}

TEST(Isolation, limits_below_one_are_kept_as_well) {
  Told told(4);
  told.limits.drift_limit = 0.5;
  told.limits.drift_lead = 0.1;
  EXPECT_EQ(told.judge_at(begin_s + 1000.0).channel, -1);
  EXPECT_EQ(told.judge_at(begin_s + 1010.0, {0.65, 0.8, 0, 0}).channel, 1);
}

TEST(Isolation, what_reads_first_after_the_quarter_of_an_hour_has_nothing_to_forget) {
  for (const bool restarted : {false, true}) {
    Isolation isolation(4);
    std::vector<HealthUpdate> updates(4, {true, 0.0, 0, 300.0, 1.0});
    updates[3].taken = false;
    isolation.judge(updates, false, 0.0, {});
    updates[1].evidence = 40.0;
    EXPECT_TRUE(isolation.judge(updates, false, begin_s, {}).first);
    updates[1].evidence = 0.0;
    if (restarted) isolation.note_restart(begin_s);
    isolation.judge(updates, false, begin_s + 10.0, {});
    isolation.judge(updates, false, begin_s + 1000.0, {});
    updates[3] = {true, 30.5, 0, 300.0, 1.0};
    EXPECT_EQ(isolation.judge(updates, false, begin_s + 1010.0, {}).channel, 3);
  }
}

TEST(Isolation, the_misfits_of_two_are_held_against_the_places_of_each_other) {
  const HealthLimits limits;
  const HealthUpdate one{true, 40.0, 0, 305.0, 3.0}, other{true, 38.0, 0, 300.5, -2.0};
  // Others say 302 K of the first place and 302.5 K of the second.
  EXPECT_DOUBLE_EQ(Isolation::left_when_swapped(one, other, limits), (2.5 + 1.5) / 5.0);
  EXPECT_DOUBLE_EQ(Isolation::left_when_swapped(other, one, limits), (2.5 + 1.5) / 5.0);
  const auto left = [&](double misfit_K, double other_K) {
    return Isolation::left_when_swapped({true, 0.0, 0, 300.0, misfit_K}, {true, 0.0, 0, 300.0, other_K}, limits);
  };
  EXPECT_TRUE(std::isfinite(left(0.66, -1.0)));
  EXPECT_TRUE(std::isfinite(left(4.0, -2.64)));
  EXPECT_TRUE(std::isinf(left(0.64, -1.0))) << "one bends what is said of the other, but less";
  EXPECT_TRUE(std::isinf(left(4.0, -2.56)));
  EXPECT_TRUE(std::isinf(left(0.5, 0.5))) << "both are off to the same side";
  EXPECT_TRUE(std::isinf(left(0.0, 0.0)));
}

/// Two whose readings fit the places of each other, the one with more evidence in `blamed`.
Blame swapped(std::size_t channels, std::size_t blamed, std::size_t partner, bool second_reads) {
  Told told(channels);
  told.judge_at(begin_s + 1000.0);
  told.updates[blamed] = {true, 40.0, 0, 302.0, 2.0};
  told.updates[partner] = {second_reads, 38.0, 0, 300.0, -2.0};
  return told.judge_at(begin_s + 1050.0);
}

TEST(Isolation, any_two_of_four_are_swapped_by_their_evidence_and_of_three_none) {
  for (std::size_t blamed = 0; blamed < 4; ++blamed) {
    for (std::size_t partner = 0; partner < 4; ++partner) {
      if (blamed == partner) continue;
      const Blame blame = swapped(4, blamed, partner, true);
      EXPECT_EQ(blame.channel, static_cast<int>(blamed));
      EXPECT_EQ(blame.partner, static_cast<int>(partner));
      EXPECT_EQ(blame.fault, HealthFault::swapped);
      if (blamed == 3 || partner == 3) continue;
      EXPECT_EQ(swapped(3, blamed, partner, true).channel, -1);
    }
  }
  EXPECT_EQ(swapped(5, 1, 3, false).partner, -1) << "of what does not read nothing is known";
}

TEST(Isolation, any_two_of_four_are_swapped_by_their_movement_and_of_three_none) {
  for (const std::size_t channels : {std::size_t{3}, std::size_t{4}}) {
    for (std::size_t partner = 0; partner < 2; ++partner) {
      Told told(channels);
      told.judge_at(begin_s + 1000.0);
      told.updates[2].moves_like = static_cast<int>(partner);
      told.updates[2].evidence = 31.0;
      told.updates[partner].evidence = 30.0;
      const Blame blame = told.judge_at(begin_s + 2000.0);
      EXPECT_EQ(blame.channel, channels == 4 ? 2 : -1);
      EXPECT_EQ(blame.partner, channels == 4 ? static_cast<int>(partner) : -1);
    }
  }
}

TEST(Isolation, of_several_places_it_is_swapped_with_the_one_that_fits_best) {
  for (const std::size_t best : {std::size_t{2}, std::size_t{4}}) {
    Told told(6);
    told.judge_at(begin_s + 1000.0);
    told.updates[1] = {true, 40.0, 0, 302.0, 2.0};
    told.updates[2] = told.updates[3] = told.updates[4] = {true, 20.0, 0, 300.4, -2.0};
    told.updates[best].reading_K = 300.1;
    EXPECT_EQ(told.judge_at(begin_s + 1050.0).partner, static_cast<int>(best));
  }
}

}  // namespace health_isolation_limits_test
}  // namespace spindle_twin::correction::test

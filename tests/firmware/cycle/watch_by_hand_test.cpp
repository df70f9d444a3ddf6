#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "tests/firmware/support/watched.hpp"

/// The watch over the sensors, told step by step what they read.
namespace spindle_twin::firmware {
namespace cycle_watch_by_hand_test {

constexpr std::int64_t s_ns = 1'000'000'000;

/// A model that stands still at start_K, and three sensors that read it.
struct ByHand {
  explicit ByHand(const CyclePlan& of_plan) : plan(of_plan), machine(network, 1.0) {
    for (std::size_t k = 0; k < 3; ++k) sensed.sensors[k] = {start_K, 0.0, s_ns};
    judgement.signals[0] = judgement.signals[1] = 0.0;
  }
  /// One cycle: what the devices said is judged by range and age, then by the watch.
  void look(bool is_new = true) {
    if (is_new) time_ns += s_ns;
    for (std::size_t k = 0; k < 3; ++k) {
      sensed.sensors[k] = {reads_K[k], 0.0, time_ns};
    }
    subtract_tare(watch, sensed);
    judge(plan, sensed, judgement);
    judgement.signals[0] = speed_rpm;
    judgement.signals[1] = load;
    const Period period{at_s, 1.0};
    watch_sensors({network, plan, sensed, machine.model, machine.model, period}, watch, corrector, judgement);
    at_s += 1.0;
  }
  correction::TareWait waits_for() const { return watch.resting->outlook().waits_for; }

  CyclePlan plan;
  rom::Network network = tests::small_network();
  Corrector corrector = make_corrector(network, plan, runtime);
  SensorWatch watch = make_watch(network, plan, corrector);
  Machine machine;
  SensedInputs sensed;
  Judgement judgement = first_judgement(plan);
  std::array<double, 3> reads_K{start_K, start_K, start_K};
  double speed_rpm = 0.0, load = 0.0;
  std::int64_t time_ns = s_ns;
  double at_s = 0.0;
};

TEST(WatchByHand, up_to_a_turn_a_minute_and_a_hundredth_of_the_load_is_rest) {
  struct Case {
    double speed_rpm, load;
    bool rests;
  };
  for (const Case& of : {Case{0.0, 0.0, true}, Case{1.0, 0.01, true}, Case{-1.0, -0.01, true}, Case{1.01, 0.0, false},
                         Case{-1.01, 0.0, false}, Case{0.0, 0.0101, false}, Case{0.0, -0.0101, false}}) {
    ByHand hand(with_sensors());
    hand.speed_rpm = of.speed_rpm;
    hand.load = of.load;
    hand.look();
    EXPECT_EQ(hand.waits_for(), of.rests ? correction::TareWait::rest : correction::TareWait::heat)
        << of.speed_rpm << " rpm, load " << of.load;
  }
}

TEST(WatchByHand, a_repeat_of_a_reading_is_as_good_as_that_was) {
  for (std::size_t off = 0; off < 3; ++off) {
    ByHand hand(with_sensors());
    for (int n = 0; n < 20; ++n) hand.look();
    EXPECT_EQ(hand.judgement.good, 3U);
    hand.reads_K[off] = start_K + 5.0;
    hand.look();
    for (int n = 0; n < 3; ++n) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(hand.judgement.sensors[k], k == off ? SensorQuality::withheld : SensorQuality::good) << n;
      }
      EXPECT_EQ(hand.judgement.good, 2U);
      EXPECT_EQ(hand.watch.health->record(off).state, correction::HealthState::suspect) << "repeats say nothing new";
      hand.look(false);
    }
    hand.reads_K[off] = start_K;
    for (const bool is_new : {true, false}) {
      hand.look(is_new);
      EXPECT_EQ(hand.judgement.sensors[off], SensorQuality::good);
      EXPECT_EQ(hand.judgement.good, 3U);
    }
  }
}

TEST(WatchByHand, a_reading_out_of_range_tells_a_broken_wire_from_a_hot_place) {
  ByHand hand(with_sensors());
  for (int n = 0; n < 10; ++n) hand.look();
  hand.reads_K[0] = 1123.15;
  hand.reads_K[2] = 500.0;
  for (int n = 0; n < 5; ++n) hand.look();
  EXPECT_EQ(hand.watch.health->record(0).fault, correction::HealthFault::open);
  EXPECT_EQ(hand.watch.health->record(2).fault, correction::HealthFault::out_of_range);
  EXPECT_EQ(hand.judgement.sensors[0], SensorQuality::out_of_range) << "what range says stays";
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(hand.watch.samples.tare[k].valid, k == 1) << "nor is it tared";
}

TEST(WatchByHand, one_tare_behind_another_takes_the_same_offsets_of_readings_as_they_come_in) {
  CyclePlan plan = at_rest(estimated());
  plan.tare.rest_s = plan.tare.block_s = 60.0;
  ByHand hand(plan);
  hand.reads_K = {start_K + 0.2, start_K - 0.1, start_K - 0.1};
  for (int tares = 1; tares <= 3; ++tares) {
    for (int n = 0; n < 180; ++n) hand.look();
    ASSERT_TRUE(take_sensor_order(SensorOrder::tare, plan, hand.judgement, hand.watch, hand.corrector));
    EXPECT_EQ(hand.watch.tare.count, static_cast<std::uint32_t>(tares));
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(hand.watch.tare.offset_K[k], hand.reads_K[k] - start_K, 1e-9) << tares;
    }
    hand.look();
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(hand.sensed.raw_K[k], hand.reads_K[k]);
      EXPECT_NEAR(hand.sensed.sensors[k].value, start_K, 1e-9);
    }
  }
}

TEST(WatchByHand, a_tare_is_as_sure_as_the_noisiest_sensor_in_use) {
  const auto deviation_K = [](double noise_K, double of_unused_K) {
    CyclePlan plan = at_rest(with_sensors());
    plan.tare.rest_s = plan.tare.block_s = 60.0;
    plan.sensors[1].noise_K = noise_K;
    plan.sensors[5].noise_K = of_unused_K;
    ByHand hand(plan);
    for (int n = 0; n < 180; ++n) hand.look();
    EXPECT_TRUE(take_sensor_order(SensorOrder::tare, plan, hand.judgement, hand.watch, hand.corrector));
    return hand.watch.tare.deviation_K[0];
  };
  const double common_K = correction::TareLimits{}.common_deviation_K;
  EXPECT_NEAR(deviation_K(0.5, 0.0), std::hypot(0.5 / std::sqrt(120.0), common_K), 1e-9);
  EXPECT_NEAR(deviation_K(0.0, 9.0), std::hypot(0.03 / std::sqrt(120.0), common_K), 1e-9) << "that of the others";
}

TEST(WatchByHand, to_the_ambient_a_tare_counts_only_where_that_is_asked_for) {
  for (const bool to_ambient : {true, false}) {
    CyclePlan plan = at_rest(with_sensors());
    plan.tare.rest_s = plan.tare.block_s = 60.0;
    plan.tare_to_ambient = to_ambient;
    ByHand hand(plan);
    for (int n = 0; n < 180; ++n) hand.look();
    hand.judgement.signals[static_cast<std::size_t>(Signal::ambient)] = start_K - 0.25;
    ASSERT_TRUE(take_sensor_order(SensorOrder::tare, plan, hand.judgement, hand.watch, hand.corrector));
    EXPECT_NEAR(hand.watch.tare.offset_K[2], to_ambient ? 0.25 : 0.0, 1e-9);
  }
}

TEST(WatchByHand, a_tare_that_is_not_offered_changes_nothing_and_an_end_of_it_is_always_taken) {
  ByHand hand(estimated());
  correction::SensorTare tare{1, {0.1, 0.2, 0.3}, {0.01, 0.02, 0.03}};
  set_tare(tare, hand.plan, hand.watch, hand.corrector);
  EXPECT_FALSE(take_sensor_order(SensorOrder::tare, hand.plan, hand.judgement, hand.watch, hand.corrector));
  EXPECT_EQ(hand.watch.tare.offset_K, tare.offset_K);
  EXPECT_TRUE(take_sensor_order(SensorOrder::acknowledge, hand.plan, hand.judgement, hand.watch, hand.corrector));
  EXPECT_EQ(hand.watch.tare.offset_K, tare.offset_K);
  EXPECT_TRUE(take_sensor_order(SensorOrder::clear_tare, hand.plan, hand.judgement, hand.watch, hand.corrector));
  EXPECT_EQ(hand.watch.tare.offset_K, std::vector<double>(3, 0.0));
}

/// fault, latched, partner and failures of one sensor, as keep_health() writes them.
using Kept = std::array<double, 4>;

TEST(WatchByHand, what_is_kept_of_health_is_taken_to_its_ends_and_all_is_refused_beyond) {
  const Kept others{0.0, 0.0, -1.0, 0.0};
  const auto is_taken = [&](const Kept& of) {
    ByHand hand(with_sensors());
    Remembered remembered;
    for (const Kept& each : {Kept{7.0, 1.0, -1.0, 1.0}, others, of}) {
      remembered.sensor_health.insert(remembered.sensor_health.end(), each.begin(), each.end());
    }
    resume_health(remembered, 0.0, hand.watch);
    return hand.watch.health->kept(0).fault != correction::HealthFault::none;
  };
  EXPECT_TRUE(is_taken(others));
  for (const Kept& good : {Kept{9.0, 0.0, -1.0, 1.0}, Kept{8.0, 1.0, 0.0, 1.0}, Kept{8.0, 1.0, 2.0, 1e6}}) {
    EXPECT_TRUE(is_taken(good)) << good[0] << " " << good[2] << " " << good[3];
  }
  for (const Kept& wrong :
       {Kept{10.0, 0.0, -1.0, 0.0}, Kept{-0.5, 0.0, -1.0, 0.0}, Kept{8.0, 1.0, -1.5, 1.0}, Kept{8.0, 1.0, 3.0, 1.0},
        Kept{7.0, 1.0, -1.0, -0.5}, Kept{7.0, 1.0, -1.0, 1000001.0}, Kept{not_a_value, 0.0, -1.0, 0.0}}) {
    EXPECT_FALSE(is_taken(wrong)) << wrong[0] << " " << wrong[2] << " " << wrong[3];
  }
}

TEST(WatchByHand, what_is_kept_of_each_sensor_comes_back_to_that_sensor) {
  ByHand before(with_sensors()), after(with_sensors());
  Remembered remembered, kept;
  remembered.sensor_health = {0.0, 0.0, -1.0, 0.0, 7.0, 1.0, -1.0, 2.0, 8.0, 1.0, 0.0, 1.0};
  resume_health(remembered, 0.0, before.watch);
  keep_health(before.watch, kept);
  EXPECT_EQ(kept.sensor_health, remembered.sensor_health);
  const std::vector<double> none{0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0};
  remembered.sensor_health.insert(remembered.sensor_health.end(), none.begin(), none.begin() + 4);
  resume_health(remembered, 0.0, after.watch);
  keep_health(after.watch, kept);
  EXPECT_EQ(kept.sensor_health, none) << "of another number of sensors nothing is known";
}

TEST(WatchByHand, is_told_of_sensors_that_are_there_and_counts_those_that_are_out) {
  CyclePlan plan = with_sensors();
  plan.sensors[1].configured = false;
  ByHand hand(plan);
  Snapshot now = first_snapshot(hand.network);
  for (int n = 0; n < 10; ++n) hand.look();
  now.sensor_quality = hand.judgement.sensors;
  publish_health(hand.watch, hand.corrector, now);
  EXPECT_TRUE(now.health_watched);
  EXPECT_EQ(now.sensors_failed, 0);
  EXPECT_EQ(now.quality & bits(Quality::sensor_failed), 0);
  EXPECT_EQ(now.sensor_tare_K[0], 0.0);
  EXPECT_TRUE(std::isnan(now.sensor_tare_K[1])) << "there is none";
  EXPECT_TRUE(std::isnan(now.sensor_health[0].misfit_ratio)) << "no estimator says what it should read";
  EXPECT_EQ(now.sensor_health[0].partner, -1);
  for (const std::size_t failing : {2U, 0U}) {
    hand.reads_K[failing] = 1123.15;
    for (int n = 0; n < 5; ++n) hand.look();
    now.sensor_quality = hand.judgement.sensors;
    now.quality = 0;
    publish_health(hand.watch, hand.corrector, now);
    EXPECT_EQ(now.sensors_failed, failing == 2 ? 1 : 2);
    EXPECT_NE(now.quality & bits(Quality::sensor_failed), 0);
    EXPECT_EQ(now.sensor_health[failing].fault, SensorFault::open);
  }
  plan.health.reset();
  ByHand unwatched(plan);
  Snapshot other = first_snapshot(hand.network);
  publish_health(unwatched.watch, unwatched.corrector, other);
  EXPECT_FALSE(other.health_watched);
}

TEST(WatchByHand, the_estimators_channel_at_a_key_point_is_found_and_of_none_there_is_none) {
  CyclePlan plan = estimated();
  plan.sensors[0].configured = false;
  const ByHand hand(plan);
  EXPECT_EQ(channel_at(hand.corrector, 0), -1);
  EXPECT_EQ(channel_at(hand.corrector, 1), 0);
  EXPECT_EQ(channel_at(hand.corrector, 2), 1);
}

/// The estimator's own offset counts from the tare: reading less tare less offset is what the model says.
TEST(WatchByHand, the_estimators_offsets_move_against_the_tare) {
  const CyclePlan plan = estimated();
  ByHand hand(plan);
  const auto offset_K = [&](Eigen::Index channel) {
    const correction::EstimatorCorrection& estimator = *hand.corrector.estimator;
    return estimator.filter().mean()[estimator.parameters().count() + channel];
  };
  const correction::SensorTare tare{1, {0.5, 0.25, -0.125}, {0.01, 0.01, 0.01}};
  for (int times = 0; times < 2; ++times) {
    set_tare(tare, plan, hand.watch, hand.corrector);
    for (Eigen::Index c = 0; c < 3; ++c) {
      EXPECT_NEAR(offset_K(c), -tare.offset_K[static_cast<std::size_t>(c)], 1e-12) << "twice is as once";
    }
  }
  take_sensor_order(SensorOrder::clear_tare, plan, hand.judgement, hand.watch, hand.corrector);
  for (Eigen::Index c = 0; c < 3; ++c) EXPECT_NEAR(offset_K(c), 0.0, 1e-12);
}

TEST(WatchByHand, a_heat_that_no_source_explains_is_looked_for_where_one_may_be_and_is_not_open_anyway) {
  const auto looks = [](const rom::Network& network, const CyclePlan& plan) {
    const Corrector corrector = make_corrector(network, plan, runtime);
    const SensorWatch watch = make_watch(network, plan, corrector);
    EXPECT_EQ(watch.others.has_value(), plan.estimator_corrects);
    EXPECT_EQ(watch.opinion.has_value(), plan.estimator_corrects);
    return watch.heat.has_value();
  };
  CyclePlan plan = estimated();
  EXPECT_TRUE(looks(tests::small_network(), plan));
  EXPECT_FALSE(looks(tests::small_network_by_hand(), plan)) << "open from the start on";
  plan.estimator->priors.disturbance = 0.0;
  EXPECT_FALSE(looks(tests::small_network(), plan));
  plan = estimated();
  plan.estimator_corrects = false;
  EXPECT_FALSE(looks(tests::small_network(), plan));
}

/// Health is told of each sensor what it read and what of that is known to be its offset.
TEST(WatchByHand, each_sample_is_the_reading_as_it_came_in_beside_the_model_and_what_is_known_of_it) {
  CyclePlan plan = estimated();
  plan.sensors[0].stale_after_s = 3.0;
  ByHand hand(plan);
  hand.reads_K = {start_K + 0.01, start_K + 0.02, start_K + 0.03};
  set_tare({1, {0.25, 0.5, -0.125}, {0.01, 0.01, 0.01}}, plan, hand.watch, hand.corrector);
  hand.corrector.estimator->note_tare(0, -4.0, 0.01);
  hand.look();
  const auto& samples = hand.watch.samples.health;
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_TRUE(samples[k].present);
    EXPECT_EQ(samples[k].reading_K, hand.reads_K[k]);
    EXPECT_EQ(samples[k].moved_K, 0.0) << "before the first cycle nothing has moved";
    EXPECT_NEAR(samples[k].offset_K, k == 0 ? 4.0 : 0.0, 1e-12) << "of the tare the estimator knows the opposite";
  }
  for (const double rise_K : {0.25, 0.5, -0.125}) {
    const Eigen::VectorXd before_K = hand.machine.model.stepper->temperatures_K();
    hand.machine.model.stepper->set_temperatures(before_K.array() + rise_K);
    predict(hand.network, hand.machine.model);
    hand.look();
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(samples[k].moved_K, rise_K, 1e-9);
      EXPECT_NEAR(samples[k].predicted_K, before_K[0] + rise_K, 1e-9);
    }
  }
  hand.look(false);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_FALSE(samples[k].present) << "a repeat";
  ByHand law(corrected());
  set_tare({1, {0.25, 0.5, -0.125}, {0.01, 0.01, 0.01}}, law.plan, law.watch, law.corrector);
  law.look();
  EXPECT_EQ(law.watch.samples.health[1].offset_K, 0.5) << "of the tare alone";
}

TEST(WatchByHand, a_sensor_that_returns_brings_an_offset_of_its_own_and_leaves_the_others_theirs) {
  for (const std::size_t off : {0U, 2U}) {
    ByHand hand(estimated());
    for (int n = 0; n < 20; ++n) hand.look();
    const Eigen::Index first = hand.corrector.estimator->parameters().count();
    const Eigen::VectorXd before_K2 = hand.corrector.estimator->covariance().diagonal();
    hand.reads_K[off] = 1123.15;
    for (int n = 0; n < 10; ++n) hand.look();
    hand.reads_K[off] = start_K;
    Snapshot now = first_snapshot(hand.network);
    bool was_returning = false;
    for (int n = 0; n < 2000 && !hand.watch.health->record(off).returned; ++n) {
      hand.look();
      now.sensor_quality = hand.judgement.sensors;
      publish_health(hand.watch, hand.corrector, now);
      was_returning = was_returning || now.sensor_health[off].state == SensorState::returning;
      const bool is_out = hand.watch.health->record(off).state != correction::HealthState::good;
      EXPECT_EQ(now.sensors_failed, is_out ? 1 : 0);
    }
    EXPECT_TRUE(was_returning);
    const correction::HealthRecord& record = hand.watch.health->record(off);
    ASSERT_TRUE(record.returned);
    const Eigen::VectorXd grown_K2 = hand.corrector.estimator->covariance().diagonal() - before_K2;
    const double own_K2 = record.return_offset_deviation_K * record.return_offset_deviation_K;
    for (Eigen::Index z = 0; z < grown_K2.size(); ++z) {
      EXPECT_NEAR(grown_K2[z], z == first + static_cast<Eigen::Index>(off) ? own_K2 : 0.0, 1e-9) << z;
    }
  }
}

TEST(WatchByHand, it_begins_without_a_tare) {
  const ByHand hand(with_sensors());
  EXPECT_EQ(hand.watch.tare.offset_K, std::vector<double>(3, 0.0));
  EXPECT_EQ(hand.watch.tare.deviation_K, std::vector<double>(3, 0.0));
}

/// Of the estimate and of the sensors' health it is told as long as the estimator corrects by it.
TEST(WatchByHand, an_estimate_in_doubt_is_told_while_it_corrects) {
  const CyclePlan plan = estimated();
  ByHand hand(plan);
  const auto update = [&] {
    for (const long before = hand.corrector.estimator->updates(); hand.corrector.estimator->updates() == before;) {
      hand.look();
      correct(hand.sensed, hand.judgement, hand.machine.operating, {hand.at_s, 1.0}, hand.machine.model,
              hand.corrector);
    }
  };
  const auto told = [&] {
    Snapshot now = first_snapshot(hand.network);
    publish_estimate(hand.corrector, now);
    publish_health(hand.watch, hand.corrector, now);
    const bool in_doubt = (now.quality & bits(Quality::estimate_in_doubt)) != 0;
    EXPECT_EQ(now.model_in_doubt, in_doubt);
    return in_doubt;
  };
  update();
  EXPECT_FALSE(told());
  hand.corrector.estimator->note_contradiction();
  update();
  ASSERT_TRUE(hand.corrector.estimator->consistency().in_doubt());
  EXPECT_TRUE(told());
  hand.corrector.enabled = false;
  EXPECT_FALSE(told());
}

}  // namespace cycle_watch_by_hand_test
}  // namespace spindle_twin::firmware

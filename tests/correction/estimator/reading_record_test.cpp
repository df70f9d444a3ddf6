#include "correction/estimator/reading_record.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace estimator_reading_record_test {

/// Two sensors whose readings come with each call.
struct Recorder {
  Recorder(const rom::Boundaries& boundaries, std::size_t capacity)
      : operating(boundaries.operating), record(boundaries, 2, capacity), reading_K(2), valid(2) {
    reading_K << 300.0, 310.0;
    valid << true, true;
  }
  bool note(double time_s, bool end = false) { return record.note(time_s, reading_K, valid, operating, end); }
  rom::OperatingState operating;
  ReadingRecord record;
  Eigen::VectorXd reading_K;
  Eigen::Array<bool, Eigen::Dynamic, 1> valid;
};

TEST(RecordedStretches, are_two_seconds_long_but_for_rounding_and_follow_each_other_without_a_gap) {
  const rom::Network network = plates();
  Recorder of(network.boundaries, 100);
  of.record.begin(5.0, of.operating);
  EXPECT_EQ(of.record.begin_s(), 5.0);
  for (int k = 1; k <= 200; ++k) EXPECT_TRUE(of.note(5.0 + 0.1 * k));  // 0.1 is no sum of powers of two
  ASSERT_EQ(of.record.count(), 10U);
  double end_s = 5.0;
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(of.record.at(i).begin_s, end_s);
    end_s = of.record.at(i).end_s;
    EXPECT_NEAR(end_s - of.record.at(i).begin_s, 2.0, 1e-9) << i;
  }
  EXPECT_TRUE(of.note(end_s + 1.999));
  EXPECT_EQ(of.record.count(), 10U);
}

TEST(RecordedStretches, that_have_no_room_any_more_are_refused_and_those_before_stay) {
  const rom::Network network = plates();
  Recorder of(network.boundaries, 3);
  of.record.begin(0.0, of.operating);
  for (const double time_s : {2.0, 4.0, 6.0}) EXPECT_TRUE(of.note(time_s));
  EXPECT_TRUE(of.note(7.0)) << "no stretch ends here";
  EXPECT_FALSE(of.note(8.0));
  ASSERT_EQ(of.record.count(), 3U);
  EXPECT_EQ(of.record.at(2).end_s, 6.0);
  of.record.begin(20.0, of.operating);
  EXPECT_EQ(of.record.begin_s(), 20.0);
  EXPECT_TRUE(of.note(22.0));
  ASSERT_EQ(of.record.count(), 1U);
  EXPECT_EQ(of.record.at(0).begin_s, 20.0);
}

TEST(RecordedStretches, hold_only_what_was_read_and_told_since_the_record_began) {
  const rom::Network network = plates();
  Recorder of(network.boundaries, 3);
  of.record.begin(0.0, of.operating);
  of.reading_K << 500.0, 600.0;
  EXPECT_TRUE(of.note(1.0));
  of.record.note_displacement({0, 1e-5, 1e-6});
  of.operating.load += 0.3;
  of.record.begin(1.5, of.operating);
  of.reading_K << 300.0, std::numeric_limits<double>::infinity();
  EXPECT_TRUE(of.note(2.5));
  of.reading_K << 301.0, 310.0;
  EXPECT_TRUE(of.note(3.5));
  ASSERT_EQ(of.record.count(), 1U);
  const RecordedReadings& only = of.record.at(0);
  EXPECT_EQ(only.begin_s, 1.5);
  EXPECT_EQ(only.reading_K, Eigen::VectorXd(Eigen::Vector2d(300.5, 310.0)));
  EXPECT_EQ(only.length.index, -1);
  EXPECT_EQ(only.operating.load, of.operating.load);
  of.reading_K << 310.0, 320.0;
  EXPECT_TRUE(of.note(5.5));
  EXPECT_EQ(of.record.at(1).reading_K, of.reading_K) << "nothing of the stretch before";
}

TEST(RecordedStretches, of_a_machine_that_tells_its_heats_call_no_heap) {
  rom::Network network = plates();
  network.boundaries.sources[1].measured = true;
  Recorder of(network.boundaries, 4);
  of.operating.heat_W = Eigen::VectorXd::Constant(1, 200.0);
  const long before = rom::tests::heap_calls();
  of.record.begin(0.0, of.operating);
  for (const double time_s : {2.0, 4.0, 6.0, 8.0}) of.note(time_s);
  const long calls = rom::tests::heap_calls() - before;
  EXPECT_EQ(calls, 0);
  EXPECT_EQ(of.record.count(), 4U);
  EXPECT_EQ(of.record.at(3).operating.heat_W[0], 200.0);
}

}  // namespace estimator_reading_record_test
}  // namespace spindle_twin::correction::test

#include "correction/health/channel_states.hpp"

#include <gtest/gtest.h>

namespace spindle_twin::correction::test {
namespace health_channel_states_test {

constexpr std::array states{HealthState::good, HealthState::suspect, HealthState::failed, HealthState::returning};
constexpr std::array events{ChannelEvent::on_course,     ChannelEvent::doubtful, ChannelEvent::fault,
                            ChannelEvent::sign_of_fault, ChannelEvent::calm,     ChannelEvent::probation_over};

bool is_out(HealthState state) { return state == HealthState::failed || state == HealthState::returning; }

TEST(ChannelStates, every_state_fails_by_a_fault_and_only_a_channel_in_use_counts_it) {
  for (const HealthState state : states) {
    const auto [next, action] = transition(state, ChannelEvent::fault);
    EXPECT_EQ(next, HealthState::failed);
    EXPECT_EQ(action, is_out(state) ? ChannelAction::fail_again : ChannelAction::fail);
  }
}

TEST(ChannelStates, a_channel_that_is_out_comes_back_by_its_probation_only) {
  for (const HealthState state : {HealthState::failed, HealthState::returning}) {
    for (const ChannelEvent event : events) {
      const auto [next, action] = transition(state, event);
      const bool over = event == ChannelEvent::probation_over;
      EXPECT_EQ(is_out(next), !over);
      EXPECT_EQ(action == ChannelAction::readmit, over);
      EXPECT_NE(action, ChannelAction::use);
    }
  }
}

TEST(ChannelStates, a_reading_on_course_is_used_and_a_doubtful_one_withheld_in_use) {
  for (const HealthState state : {HealthState::good, HealthState::suspect}) {
    EXPECT_EQ(transition(state, ChannelEvent::on_course).next, HealthState::good);
    EXPECT_EQ(transition(state, ChannelEvent::on_course).action, ChannelAction::use);
    EXPECT_EQ(transition(state, ChannelEvent::doubtful).next, HealthState::suspect);
    EXPECT_EQ(transition(state, ChannelEvent::doubtful).action, ChannelAction::withhold);
    for (const ChannelEvent event : {ChannelEvent::sign_of_fault, ChannelEvent::calm, ChannelEvent::probation_over}) {
      EXPECT_EQ(transition(state, event).next, state);
      EXPECT_EQ(transition(state, event).action, ChannelAction::none);
    }
  }
}

TEST(ChannelStates, a_sign_of_the_fault_ends_the_probation) {
  EXPECT_EQ(transition(HealthState::failed, ChannelEvent::calm).next, HealthState::returning);
  EXPECT_EQ(transition(HealthState::returning, ChannelEvent::sign_of_fault).next, HealthState::failed);
  EXPECT_EQ(transition(HealthState::returning, ChannelEvent::sign_of_fault).action, ChannelAction::restart_probation);
  EXPECT_EQ(transition(HealthState::returning, ChannelEvent::doubtful).next, HealthState::returning);
  EXPECT_EQ(transition(HealthState::returning, ChannelEvent::doubtful).action, ChannelAction::restart_probation);
}

}  // namespace health_channel_states_test
}  // namespace spindle_twin::correction::test

#pragma once

#include <array>
#include <cstddef>

#include "correction/health/record.hpp"

namespace spindle_twin::correction {

/// What one reading, or the evidence of all, says of a channel.
enum class ChannelEvent {
  on_course,       ///< nothing is wrong with this reading
  doubtful,        ///< something is, but one such reading proves nothing
  fault,           ///< a detector is sure
  sign_of_fault,   ///< of a channel that is out: the fault is still there
  calm,            ///< of a channel that is out: no sign of it, for less than return_after_s
  probation_over,  ///< of a channel that is out: no sign of it for return_after_s
};

/// What the channel does about it.
enum class ChannelAction {
  none,
  use,                ///< the reading is used
  withhold,           ///< it is not, and the record names the cause
  fail,               ///< the failure counts, and may latch the channel
  fail_again,         ///< it was out already: the failure does not count
  restart_probation,  ///< the time without a sign of a fault begins anew
  readmit,            ///< the reading is used, and the offset is not known any more
};

struct ChannelTransition {
  HealthState next;
  ChannelAction action;
};

/// The states of a channel: state x event -> next state and action. What cannot come in a state changes nothing.
///   A latched channel gets no `calm` and no `probation_over` until it is acknowledged.
/// May run in the cycle.
constexpr ChannelTransition transition(HealthState state, ChannelEvent event) {
  using enum HealthState;
  using Action = ChannelAction;
  constexpr std::array<std::array<ChannelTransition, 6>, 4> table{{
      // on_course, doubtful, fault,
      // sign_of_fault, calm, probation_over
      {{{good, Action::use},  // good
        {suspect, Action::withhold},
        {failed, Action::fail},
        {good, Action::none},
        {good, Action::none},
        {good, Action::none}}},
      {{{good, Action::use},  // suspect
        {suspect, Action::withhold},
        {failed, Action::fail},
        {suspect, Action::none},
        {suspect, Action::none},
        {suspect, Action::none}}},
      {{{failed, Action::none},  // failed
        {failed, Action::restart_probation},
        {failed, Action::fail_again},
        {failed, Action::restart_probation},
        {returning, Action::none},
        {good, Action::readmit}}},
      {{{returning, Action::none},  // returning
        {returning, Action::restart_probation},
        {failed, Action::fail_again},
        {failed, Action::restart_probation},
        {returning, Action::none},
        {good, Action::readmit}}},
  }};
  return table[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

}  // namespace spindle_twin::correction

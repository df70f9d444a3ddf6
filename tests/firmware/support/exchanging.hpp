#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "firmware/cycle/exchange.hpp"
#include "firmware/cycle/start_field.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::firmware {

/// A machine of the small network, a twin on a network that may be wrong, and another that it may be exchanged for.
struct Exchanging {
  Exchanging(const rom::Network& runs, const rom::Network& comes, const CyclePlan& plan, const ExchangePlan& judged,
             const MakeStepper& runs_by = runtime, const MakeStepper& comes_by = runtime)
      : old_network(runs),
        new_network(comes),
        old_cycle(old_network, plan, runs_by),
        new_cycle(new_network, plan, comes_by),
        exchange(old_cycle, judged) {
    old_cycle.identify(std::string(64, 'a'));
    new_cycle.identify(std::string(64, 'b'));
  }

  const Snapshot& step() {
    before = last;
    const DeviceFrame frame = machine.frame(at_s(n));
    const long calls_before = rom::tests::heap_calls();
    const Snapshot& now = exchange.step(frame, command, at_s(n), 0);
    heap_calls += rom::tests::heap_calls() - calls_before;
    last = now;
    ++n;
    machine.advance(1.0);
    largest_way_m = std::max(largest_way_m, way_of(last));
    return last;
  }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) step();
  }
  /// How many steps it took until `state`; `most` if it did not come.
  int until(ExchangeState state, int most) {
    int steps = 0;
    while (steps < most && last.exchange.state != state) {
      step();
      ++steps;
    }
    return steps;
  }
  /// The largest way that anything published goes in a cycle until `state`.
  double way_until(ExchangeState state, int most) {
    largest_way_m = 0.0;
    until(state, most);
    return largest_way_m;
  }
  double way_of(const Snapshot& now) const {
    return std::max({std::abs(now.nose_m - before.nose_m), std::abs(now.deformation_m[0] - before.deformation_m[0]),
                     std::abs(now.deformation_m[1] - before.deformation_m[1]),
                     std::abs(now.compensation.value_m - before.compensation.value_m)});
  }
  void offer(Cycle& candidate) {
    candidate.start_at(start_field(new_network, last));
    exchange.offer(candidate);
  }
  ExchangeNews news() {
    ExchangeNews told;
    EXPECT_TRUE(exchange.read(told));
    return told;
  }
  bool shows_new() const { return last.network_id == 0xbbbbbbbbU; }

  rom::Network true_network = tests::small_network();
  rom::Network old_network, new_network;
  Cycle old_cycle, new_cycle;
  NetworkExchange exchange;
  Machine machine{true_network, 1.0};
  PlcCommand command;
  Snapshot last, before;
  double largest_way_m = 0.0;
  long heap_calls = 0;  ///< of the steps
  int n = 0;
};

}  // namespace spindle_twin::firmware

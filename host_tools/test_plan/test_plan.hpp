#pragma once

#include <functional>
#include <string>
#include <vector>

#include "correction/identify/identify.hpp"
#include "correction/plan_test/plan_test.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// What a person may say of a test that is to be proposed.
struct TestWish {
  correction::DriveLimits limits;
  correction::CalibrateOptions calibrate;           ///< sensors: those in service
  std::vector<correction::SensorPlace> permanent;   ///< their places
  std::vector<correction::SensorPlace> candidates;  ///< where temporary ones could be put
  int temporary = 3;                                ///< how many of them at most
  std::size_t probe = 0;                            ///< deformation output
  correction::DriftOptions drift;
  rom::Schedule service;
};

/// One drive cycle of the table.
struct ComparedCycle {
  std::string name;
  correction::DriveCycle cycle;
  correction::Worth first;  ///< of its first correction::early_s
  correction::Worth whole;
};

struct ProposedTest {
  std::vector<correction::SensorPlace> sensors;  ///< permanent, then candidates
  std::size_t permanent = 0;
  correction::TestPlan plan;
  correction::Worth untested, known;    ///< the priors alone; a machine known at the test
  std::vector<ComparedCycle> compared;  ///< constant speeds, the spectrum, the proposal, and with its temporary sensors
  std::vector<double> time_s;           ///< of the proposal, as the network has it
  std::vector<double> growth_m;
};

/// Searches the cycle, then the sensors. `progress`: a line for a person. Throws rom::InputError as TestWorth does.
ProposedTest propose_test(const rom::Network& network, const TestWish& wish,
                          const std::function<void(const std::string&)>& progress);

/// Places that a person can put a sensor on: key points and nodes of parts that are not in `closed`, none twice and
/// none of `permanent`.
std::vector<correction::SensorPlace> reachable_places(const rom::Network& network,
                                                      const std::vector<std::string>& closed,
                                                      const std::vector<correction::SensorPlace>& permanent);

/// The schedule as `simulate` reads it: time_s,speed_rpm,load.
std::string schedule_csv(const correction::DriveCycle& cycle, const correction::DriveLimits& limits);

/// "12000 rpm 20 min, 0 rpm 15 min".
std::string in_words(const correction::DriveCycle& cycle);

}  // namespace spindle_twin::host_tools

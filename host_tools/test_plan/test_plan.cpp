#include "host_tools/test_plan/test_plan.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <stdexcept>

#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using correction::DriveCycle;
using correction::TestPrediction;
using correction::TestWorth;

constexpr double search_interval_s = 120.0;  // between readings that count
constexpr double shown_every_s = 60.0;

/// The cycles that a proposal is compared with.
std::vector<ComparedCycle> usual_cycles(const TestWish& wish, double operating_rpm) {
  const correction::DriveLimits& limits = wish.limits;
  std::vector<ComparedCycle> cycles;
  const auto constant = [&](double speed_rpm) {
    cycles.push_back(
        {fmt::format("constant {:g} rpm", speed_rpm), correction::constant_cycle(speed_rpm, limits.length_s), {}, {}});
  };
  if (operating_rpm > 0.0 && operating_rpm < limits.top_rpm) constant(operating_rpm);
  constant(limits.top_rpm);
  cycles.push_back({"speed spectrum, ISO 230-3", correction::spectrum_cycle(limits), {}, {}});
  return cycles;
}

correction::TakenReadings taken(std::vector<std::size_t> sensors, double until_s) {
  correction::TakenReadings readings;
  readings.sensors = std::move(sensors);
  readings.until_s = until_s;
  return readings;
}

void simulate_growth(const rom::Network& network, const TestWish& wish, ProposedTest& test) {
  const rom::Schedule schedule = correction::schedule_of(test.plan.cycle, wish.limits, network.boundaries);
  const rom::CorrectionFactors factors = rom::no_correction(network.boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::OperatingState state = schedule.rows.front().state;
  const auto stepper = rom::make_runtime_stepper(network);
  stepper->set_temperatures(
      Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), rom::rest_temperature_K(network.boundaries, state)));
  const Eigen::VectorXd& row = network.deformations[wish.probe].row_m_per_K;
  const auto note = [&](double time_s) {
    test.time_s.push_back(time_s);
    test.growth_m.push_back(row.dot(stepper->temperatures_K()) -
                            row.sum() * network.boundaries.reference_temperature_K);
  };
  note(0.0);
  for (double time_s = 0.0; time_s < schedule.end_s - 1e-6;) {
    const double end_s = std::min(time_s + shown_every_s, schedule.end_s);
    rom::state_at(schedule, 0.5 * (time_s + end_s), state);
    rom::evaluate_boundaries(network.boundaries, state, factors, values);
    if (stepper->advance(end_s - time_s, values) != rom::StepStatus::ok) {
      throw std::runtime_error("the network has no solution at " + std::to_string(time_s) + " s");
    }
    time_s = end_s;
    note(time_s);
  }
}

correction::EstimatorSensor sensor_at(const correction::SensorPlace& place) {
  correction::EstimatorSensor sensor;
  sensor.name = place.name;
  sensor.row = place.row;
  return sensor;
}

}  // namespace

ProposedTest propose_test(const rom::Network& network, const TestWish& wish,
                          const std::function<void(const std::string&)>& progress) {
  const auto say = [&](const std::string& words) {
    if (progress) progress(words);
  };
  correction::WorthOptions options{correction::thinned(wish.calibrate, search_interval_s), wish.permanent.size(),
                                   wish.drift, wish.probe};
  say("the service drive");
  const TestWorth cycles(network, options, wish.service);
  std::vector<std::size_t> permanent;
  for (std::size_t s = 0; s < wish.permanent.size(); ++s) permanent.push_back(s);
  ProposedTest test;
  test.permanent = permanent.size();
  test.untested = cycles.untested();
  test.known = cycles.known();
  test.plan = correction::plan_cycle(cycles, wish.limits, network.boundaries, permanent, [&](int count, double best_m) {
    say(fmt::format("{} drive cycles, the best leaves {:.2f} um", count, rom::um_per_m * best_m));
  });
  test.compared = usual_cycles(wish, network.boundaries.operating.speed_rpm);
  test.compared.push_back({"proposed", test.plan.cycle, {}, {}});
  for (ComparedCycle& cycle : test.compared) {
    say(cycle.name);
    const TestPrediction prediction =
        cycles.linearise(correction::schedule_of(cycle.cycle, wish.limits, network.boundaries));
    cycle.first = cycles.of(prediction, taken(permanent, correction::early_s));
    cycle.whole = cycles.of(prediction, taken(permanent, wish.limits.length_s));
  }

  test.sensors = wish.permanent;
  test.sensors.insert(test.sensors.end(), wish.candidates.begin(), wish.candidates.end());
  correction::CalibrateOptions with_candidates = wish.calibrate;
  for (const correction::SensorPlace& place : wish.candidates) with_candidates.sensors.push_back(sensor_at(place));
  options.calibrate = correction::thinned(std::move(with_candidates), search_interval_s);
  say("temporary sensors");
  const TestWorth sensors(network, options, wish.service);
  const TestPrediction prediction =
      sensors.linearise(correction::schedule_of(test.plan.cycle, wish.limits, network.boundaries));
  correction::plan_sensors(sensors, prediction, permanent, wish.candidates.size(), wish.temporary, test.plan);
  if (!test.plan.temporary.empty()) {
    std::vector<std::size_t> all = permanent;
    for (const correction::SensorWorth& one : test.plan.temporary) all.push_back(one.sensor);
    test.compared.push_back({"proposed, temporary sensors too", test.plan.cycle,
                             sensors.of(prediction, taken(all, correction::early_s)),
                             sensors.of(prediction, taken(all, wish.limits.length_s))});
  }
  simulate_growth(network, wish, test);
  return test;
}

std::vector<correction::SensorPlace> reachable_places(const rom::Network& network,
                                                      const std::vector<std::string>& closed,
                                                      const std::vector<correction::SensorPlace>& permanent) {
  std::vector<correction::SensorPlace> places;
  for (correction::SensorPlace& place : correction::sensor_places(network)) {
    const bool is_point = !place.part.empty() && place.name != place.part;
    const bool is_closed = std::find(closed.begin(), closed.end(), place.part) != closed.end();
    const auto is_known = [&](const std::vector<correction::SensorPlace>& list) {
      return std::any_of(list.begin(), list.end(), [&](const auto& other) {
        return other.name == place.name || (other.row - place.row).isZero(1e-12);
      });
    };
    if (is_point && !is_closed && !is_known(permanent) && !is_known(places)) places.push_back(std::move(place));
  }
  return places;
}

std::string schedule_csv(const correction::DriveCycle& cycle, const correction::DriveLimits& limits) {
  std::string text = "time_s,speed_rpm,load\n";
  double time_s = 0.0;
  const auto add = [&](double speed_rpm) {
    text += fmt::format("{:.10g},{:.10g},{:.10g}\n", time_s, speed_rpm, speed_rpm > 0.0 ? limits.load : 0.0);
  };
  for (const correction::Stage& stage : cycle) {
    add(stage.speed_rpm);
    time_s += stage.length_s;
  }
  add(cycle.back().speed_rpm);
  return text;
}

std::string in_words(const correction::DriveCycle& cycle) {
  std::string words;
  for (const correction::Stage& stage : cycle) {
    words += fmt::format("{}{:g} rpm {:g} min", words.empty() ? "" : ", ", stage.speed_rpm,
                         stage.length_s / rom::seconds_per_minute);
  }
  return words;
}

}  // namespace spindle_twin::host_tools

#include "host_tools/test_plan/describe_test.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "host_tools/pages/outlines.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double millimetres_per_metre = 1e3;
constexpr std::size_t shown_places = 8;

Json worth_json(const correction::Worth& worth) {
  return {{"with_sensors_um", rom::um_per_m * worth.with_sensors_m},
          {"open_loop_um", rom::um_per_m * worth.open_loop_m}};
}

Json place_json(const correction::SensorPlace& place, double deviation_m) {
  return {{"name", place.name},
          {"part", place.part},
          {"at_m", {place.r_m, place.z_m}},
          {"um", rom::um_per_m * deviation_m}};
}

Json stages_json(const correction::DriveCycle& cycle) {
  Json list = Json::array();
  double from_s = 0.0;
  for (const correction::Stage& stage : cycle) {
    list.push_back({{"from_s", from_s}, {"for_s", stage.length_s}, {"speed_rpm", stage.speed_rpm}});
    from_s += stage.length_s;
  }
  return list;
}

Json compared_json(const ProposedTest& test) {
  Json list = Json::array();
  for (const ComparedCycle& cycle : test.compared) {
    list.push_back({{"name", cycle.name},
                    {"stages", stages_json(cycle.cycle)},
                    {"first", worth_json(cycle.first)},
                    {"whole", worth_json(cycle.whole)}});
  }
  return list;
}

const char* role_of(const ProposedTest& test, std::size_t sensor) {
  return sensor < test.permanent ? "permanent" : "temporary";
}

Json used_sensors_json(const ProposedTest& test) {
  Json list = Json::array();
  for (const correction::SensorWorth& one : test.plan.without) {
    Json sensor = place_json(test.sensors[one.sensor], 0.0);
    sensor.erase("um");
    sensor["role"] = role_of(test, one.sensor);
    sensor["without_um"] = rom::um_per_m * one.worth.with_sensors_m;
    list.push_back(sensor);
  }
  return list;
}

Json places_json(const ProposedTest& test) {
  Json list = Json::array();
  for (const correction::SensorWorth& one : test.plan.candidates) {
    list.push_back(place_json(test.sensors[one.sensor], one.worth.with_sensors_m));
  }
  return list;
}

double speed_at(const correction::DriveCycle& cycle, double time_s) {
  for (const correction::Stage& stage : cycle) {
    if (time_s < stage.length_s) return stage.speed_rpm;
    time_s -= stage.length_s;
  }
  return cycle.back().speed_rpm;
}

std::string left_out(const std::vector<std::string>& turning) {
  if (turning.empty()) return "";
  std::string words = "Not on what turns: ";
  for (std::size_t i = 0; i < turning.size(); ++i) words += (i > 0 ? ", " : "") + turning[i];
  return words + ".";
}

void add_place(const correction::SensorPlace& place, double deviation_m, std::string& text) {
  text +=
      fmt::format("  {:<28} {:<20} r {:5.1f}  z {:6.1f} {:9.2f} um\n", place.name, place.part,
                  millimetres_per_metre * place.r_m, millimetres_per_metre * place.z_m, rom::um_per_m * deviation_m);
}

}  // namespace

Json test_json(const rom::Network& network, const TestWish& wish, const ProposedTest& test) {
  return {{"spindle", network.spindle},
          {"probe", network.deformations[wish.probe].name},
          {"untested", worth_json(test.untested)},
          {"known", worth_json(test.known)},
          {"first_s", correction::early_s},
          {"cycles_evaluated", test.plan.evaluated},
          {"top_rpm", wish.limits.top_rpm},
          {"load", wish.limits.load},
          {"proposed", stages_json(test.plan.cycle)},
          {"compared", compared_json(test)},
          {"sensors", used_sensors_json(test)},
          {"places", places_json(test)}};
}

std::string test_table(const rom::Network& network, const TestWish& wish, const ProposedTest& test) {
  const std::string& probe = network.deformations[wish.probe].name;
  std::string text = fmt::format(
      "{}: a test of {:g} h with a probe at {}, to {:g} rpm at load {:g}; {} drive cycles were looked at\n\n",
      network.spindle, wish.limits.length_s / rom::seconds_per_hour, probe, wish.limits.top_rpm, wish.limits.load,
      test.plan.evaluated);
  text += fmt::format("{:>10} {:>10} {:>12}\n", "from min", "for min", "speed rpm");
  double from_s = 0.0;
  for (const correction::Stage& stage : test.plan.cycle) {
    text += fmt::format("{:>10g} {:>10g} {:>12g}\n", from_s / rom::seconds_per_minute,
                        stage.length_s / rom::seconds_per_minute, stage.speed_rpm);
    from_s += stage.length_s;
  }
  text += fmt::format("\n1 sigma of {} in service, um\n{:<34} {:>21} {:>21}\n{:<34} {:>10} {:>10} {:>10} {:>10}\n",
                      probe, "", "30 min of test", "all of it", "", "sensors", "none", "sensors", "none");
  const auto add = [&](const std::string& name, const correction::Worth& first, const correction::Worth& whole) {
    text += fmt::format("{:<34} {:>10.2f} {:>10.2f} {:>10.2f} {:>10.2f}\n", name, rom::um_per_m * first.with_sensors_m,
                        rom::um_per_m * first.open_loop_m, rom::um_per_m * whole.with_sensors_m,
                        rom::um_per_m * whole.open_loop_m);
  };
  add("no test", test.untested, test.untested);
  for (const ComparedCycle& cycle : test.compared) add(cycle.name, cycle.first, cycle.whole);
  add("a machine known at the test", test.known, test.known);
  text += "\nTemporary sensors, one after another, and what is left with them:\n";
  for (const correction::SensorWorth& one : test.plan.temporary) {
    add_place(test.sensors[one.sensor], one.worth.with_sensors_m, text);
  }
  text += "\nWhat is left where one sensor is left out of the test:\n";
  for (const correction::SensorWorth& one : test.plan.without) {
    text += fmt::format("  {:<28} {:<39} {:9.2f} um\n", test.sensors[one.sensor].name, role_of(test, one.sensor),
                        rom::um_per_m * one.worth.with_sensors_m);
  }
  text += "\nOne temporary sensor alone, the best places:\n";
  for (std::size_t i = 0; i < std::min(shown_places, test.plan.candidates.size()); ++i) {
    const correction::SensorWorth& one = test.plan.candidates[i];
    add_place(test.sensors[one.sensor], one.worth.with_sensors_m, text);
  }
  return text;
}

Json test_page_data(const rom::Network& network, const TestWish& wish, const ProposedTest& test,
                    const std::vector<std::string>& turning) {
  const std::string& probe = network.deformations[wish.probe].name;
  const double now_um = rom::um_per_m * test.plan.worth.with_sensors_m;
  Json growth = Json::array(), speeds = Json::array();
  for (const double metre : test.growth_m) growth.push_back(rom::um_per_m * metre);
  for (const double time_s : test.time_s) speeds.push_back(speed_at(test.plan.cycle, time_s));
  Json facts = Json::array({{{"name", "left without a test"}, {"um", rom::um_per_m * test.untested.with_sensors_m}}});
  for (const ComparedCycle& cycle : test.compared) {
    facts.push_back({{"name", cycle.name}, {"um", rom::um_per_m * cycle.whole.with_sensors_m}});
  }
  facts.push_back({{"name", "a machine known at the test"}, {"um", rom::um_per_m * test.known.with_sensors_m}});
  return {{"spindle", network.spindle},
          {"deformation", probe},
          {"state",
           fmt::format("{:g} h with a probe at {}, proposed by a search over {} drive cycles; numbers are standard "
                       "deviations of {} in service that are left after the test.",
                       wish.limits.length_s / rom::seconds_per_hour, probe, test.plan.evaluated, probe)},
          {"facts", facts},
          {"left_out", left_out(turning)},
          {"now_um", now_um},
          {"outlines", outlines_json(network)},
          {"sensors", used_sensors_json(test)},
          {"places", places_json(test)},
          {"test",
           {{"load", wish.limits.load},
            {"stages", stages_json(test.plan.cycle)},
            {"compared", compared_json(test)},
            {"time_s", test.time_s},
            {"speed_rpm", speeds},
            {"growth_um", growth}}}};
}

Json sensors_page_data(const rom::Network& network, const std::vector<correction::SensorPlace>& sensors,
                       const correction::Identification& found, const std::vector<std::string>& turning) {
  const std::string& output = network.deformations.front().name;
  Json used = Json::array(), places = Json::array();
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    Json sensor = place_json(sensors[s], 0.0);
    sensor.erase("um");
    if (sensors[s].name == sensors[s].part) sensor.erase("at_m");
    sensor["role"] = "chosen";
    sensor["without_um"] = rom::um_per_m * found.without_m[s];
    used.push_back(sensor);
  }
  for (const correction::Placement& placement : found.first_placement) {
    if (placement.place.name == placement.place.part || placement.place.part.empty()) continue;
    places.push_back(place_json(placement.place, placement.deformation_m));
  }
  return {{"spindle", network.spindle},
          {"deformation", output},
          {"state",
           fmt::format("{} at the end of the drive cycle: growth {:.2f} um.", output, rom::um_per_m * found.growth_m)},
          {"facts",
           {{{"name", "1σ without sensors"}, {"um", rom::um_per_m * found.prior_m}},
            {{"name", "with these"}, {"um", rom::um_per_m * found.posterior_m}}}},
          {"left_out", left_out(turning)},
          {"now_um", rom::um_per_m * found.posterior_m},
          {"outlines", outlines_json(network)},
          {"sensors", used},
          {"places", places}};
}

}  // namespace spindle_twin::host_tools

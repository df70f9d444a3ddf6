#include "correction/identify/identify.hpp"

#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "correction/identify/turning_parts.hpp"
#include "host_tools/calibrate/test_options.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/pages/fill_page.hpp"
#include "host_tools/pages/page_texts.hpp"
#include "host_tools/test_plan/describe_test.hpp"
#include "host_tools/test_plan/test_plan.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

// spindle-twin identify reference.rom --sensors inner,middle,outer
// spindle-twin identify reference.rom --sensors inner,middle,outer --test-hours 2 --probe nose -o test.csv
namespace spindle_twin::host_tools {
namespace {

constexpr double millimetres_per_metre = 1e3;
constexpr std::size_t shown_places = 8;

struct IdentifyOptions {  // NOLINT(public-members): a member per option
  std::string network;
  std::vector<std::string> sensors;
  std::string schedule;
  double hours = 1.0;
  correction::IdentifyOptions identify;
  bool anywhere = false;
  bool json = false;
  std::string page;
  // Of a test that is to be proposed.
  std::optional<double> test_hours;
  std::string probe;
  std::string config;
  std::string output;
  std::optional<double> top_rpm;
  double shortest_min = 5.0;
  double load = 0.0;
  int temporary = 3;
};

nlohmann::ordered_json to_json(const correction::Placement& placement) {
  return {{"place", placement.place.name},
          {"part", placement.place.part},
          {"r_m", placement.place.r_m},
          {"z_m", placement.place.z_m},
          {"deviation_um", rom::um_per_m * placement.deformation_m}};
}

void print_json(const rom::Network& network, const std::vector<correction::SensorPlace>& sensors,
                const correction::Identification& found) {
  nlohmann::ordered_json result;
  result["spindle"] = network.spindle;
  result["deformation"] = network.deformations.front().name;
  for (const correction::SensorPlace& sensor : sensors) result["sensors"].push_back(sensor.name);
  result["growth_um"] = rom::um_per_m * found.growth_m;
  result["prior_deviation_um"] = rom::um_per_m * found.prior_m;
  result["posterior_deviation_um"] = rom::um_per_m * found.posterior_m;
  for (const correction::IdentifiedParameter& parameter : found.parameters) {
    result["parameters"].push_back({{"name", parameter.name},
                                    {"kind", correction::name_of(parameter.kind)},
                                    {"prior_deviation", parameter.estimate.prior_deviation},
                                    {"posterior_deviation", parameter.estimate.deviation},
                                    {"determined", !parameter.estimate.undetermined()}});
  }
  for (const correction::Placement& placement : found.placements) result["placements"].push_back(to_json(placement));
  for (const correction::Placement& placement : found.first_placement) {
    result["next_sensor"].push_back(to_json(placement));
  }
  std::printf("%s\n", result.dump(2).c_str());
}

void print_place(const correction::Placement& placement) {
  const correction::SensorPlace& place = placement.place;
  std::printf("  %-28s %-20s", place.name.c_str(), place.part.c_str());
  if (place.name == place.part) {
    std::printf(" %18s", "mean of the part");
  } else {
    std::printf(" r %5.1f  z %6.1f", millimetres_per_metre * place.r_m, millimetres_per_metre * place.z_m);
  }
  std::printf(" %9.2f um\n", rom::um_per_m * placement.deformation_m);
}

void print_table(const rom::Network& network, const std::vector<correction::SensorPlace>& sensors,
                 const correction::Identification& found) {
  std::string names;
  for (const correction::SensorPlace& sensor : sensors) names.append(names.empty() ? "" : ", ").append(sensor.name);
  std::printf("%s, %s at the end of the drive cycle: growth %.2f um\n", network.spindle.c_str(),
              network.deformations.front().name.c_str(), rom::um_per_m * found.growth_m);
  std::printf("  standard deviation without sensors %6.2f um\n", rom::um_per_m * found.prior_m);
  std::printf("  with %-28s %6.2f um\n\n", names.c_str(), rom::um_per_m * found.posterior_m);
  std::printf("%-50s %8s %10s %6s\n", "ln of the factor on, standard deviation", "prior", "posterior", "ratio");
  std::size_t open = 0;
  for (const correction::IdentifiedParameter& parameter : found.parameters) {
    const correction::ParameterEstimate& estimate = parameter.estimate;
    std::printf("%-50s %8.3f %10.3f %6.2f%s\n", parameter.name.c_str(), estimate.prior_deviation, estimate.deviation,
                estimate.deviation / estimate.prior_deviation, estimate.undetermined() ? "  not determined" : "");
    open += estimate.undetermined() ? 1 : 0;
  }
  std::printf("\n%zu of %zu parameters are not determined: these sensors tell less than a tenth of their deviation.\n",
              open, found.parameters.size());
  if (found.placements.empty()) return;
  std::printf("\nFurther sensors, one after another, and what is left of the standard deviation:\n");
  for (const correction::Placement& placement : found.placements) print_place(placement);
  std::printf("\nThe next one alone, the best places:\n");
  for (std::size_t i = 0; i < std::min(shown_places, found.first_placement.size()); ++i) {
    print_place(found.first_placement[i]);
  }
}

std::size_t probe_index(const rom::Network& network, const std::string& name) {
  if (network.deformations.empty()) throw rom::InputError({}, "--probe", "the network has no deformation output");
  if (name.empty()) return 0;
  std::string list;
  for (std::size_t d = 0; d < network.deformations.size(); ++d) {
    if (network.deformations[d].name == name) return d;
    list.append(list.empty() ? "" : ", ").append(network.deformations[d].name);
  }
  throw rom::InputError({}, "--probe", "'" + name + "' is no deformation output; allowed: " + list);
}

TestWish wish_of(const IdentifyOptions& options, const rom::Network& network,
                 const std::vector<correction::SensorPlace>& sensors) {
  TestWish wish;
  wish.calibrate = test_options(network, options.config);
  std::vector<correction::EstimatorSensor> used;
  for (const correction::SensorPlace& place : sensors) {
    const auto known = std::find_if(wish.calibrate.sensors.begin(), wish.calibrate.sensors.end(),
                                    [&](const correction::EstimatorSensor& one) { return one.name == place.name; });
    used.push_back(known == wish.calibrate.sensors.end() ? correction::EstimatorSensor{} : *known);
    used.back().name = place.name;
    used.back().row = place.row;
  }
  wish.calibrate.sensors = std::move(used);
  wish.permanent = sensors;
  wish.candidates = reachable_places(network, options.identify.closed_parts, sensors);
  wish.temporary = options.temporary;
  wish.probe = probe_index(network, options.probe);
  wish.limits.length_s = rom::seconds_per_hour * *options.test_hours;
  wish.limits.top_rpm = options.top_rpm.value_or(network.boundaries.operating.speed_rpm);
  wish.limits.shortest_s = rom::seconds_per_minute * options.shortest_min;
  wish.limits.load = options.load;
  if (wish.limits.top_rpm <= 0.0)
    throw rom::InputError({}, "--top-speed", "is needed: the network is described at standstill");
  if (wish.limits.shortest_s > wish.limits.length_s) {
    throw rom::InputError({}, "--shortest-min", "is longer than the test");
  }
  wish.service = options.schedule.empty() ? correction::usual_service(wish.limits.top_rpm, network.boundaries)
                                          : rom::read_schedule(options.schedule, network.boundaries);
  return wish;
}

void propose(const IdentifyOptions& options, const rom::Network& network,
             const std::vector<correction::SensorPlace>& sensors) {
  const TestWish wish = wish_of(options, network, sensors);
  const bool shows = isatty(STDERR_FILENO) == 1;
  const ProposedTest test = propose_test(network, wish, [&](const std::string& words) {
    if (shows) std::fprintf(stderr, "\r\033[K%s", words.c_str());
  });
  if (shows) std::fprintf(stderr, "\r\033[K");
  if (!options.output.empty()) rom::write_whole_file(options.output, schedule_csv(test.plan.cycle, wish.limits));
  if (!options.page.empty()) {
    rom::write_whole_file(
        options.page, fill_page(sensors_page_text, test_page_data(network, wish, test, options.identify.closed_parts)));
  }
  std::printf("%s%s", (options.json ? test_json(network, wish, test).dump(2) : test_table(network, wish, test)).c_str(),
              options.json ? "\n" : "");
}

void run_identify(IdentifyOptions options) {
  for (const auto& [file, field] : {std::pair(options.output, "--output"), std::pair(options.page, "--html")}) {
    if (!file.empty()) rom::check_writable(file, field);
  }
  const rom::Network network = rom::read_network(options.network);
  std::vector<std::string> names = options.sensors;
  if (names.empty()) {
    for (const rom::KeyPoint& point : network.key_points) names.push_back(point.name);
  }
  correction::find_places(network, options.identify.closed_parts, "--not-on");
  const std::vector<correction::SensorPlace> sensors = correction::find_places(network, names, "--sensors");
  if (!options.anywhere) {
    for (std::string& part : correction::turning_parts(network)) {
      options.identify.closed_parts.push_back(std::move(part));
    }
  }
  if (options.test_hours) {
    propose(options, network, sensors);
    return;
  }
  const rom::Schedule schedule = options.schedule.empty()
                                     ? rom::constant_schedule(network.boundaries, 3600.0 * options.hours)
                                     : rom::read_schedule(options.schedule, network.boundaries);
  const correction::Identification found = correction::identify(network, sensors, schedule, options.identify);
  if (!options.page.empty()) {
    rom::write_whole_file(options.page, fill_page(sensors_page_text, sensors_page_data(network, sensors, found,
                                                                                       options.identify.closed_parts)));
  }
  options.json ? print_json(network, sensors, found) : print_table(network, sensors, found);
}

void add_test_options(CLI::App& command, IdentifyOptions& options) {
  CLI::Option* test =
      command
          .add_option(
              "--test-hours", options.test_hours,
              "propose a test of this length: drive cycle and temporary sensors; priors, drift and errors are those "
              "of `calibrate`, --schedule is the service that it is for")
          ->check(finite_range(0.25, 24.0, "0.25 to 24 h"));
  const auto of_test = [&](const char* name, auto& value, const char* words) {
    return command.add_option(name, value, words)->needs(test);
  };
  of_test("--probe", options.probe, "deformation output with a probe during the test; default: the first");
  of_test("--config", options.config, "the daemon's configuration: its priors, noise, offsets and lags");
  of_test("--top-speed", options.top_rpm, "of the machine, rpm; default: the described operating speed")
      ->check(finite_range(1.0, 1e6, "1 to 1e6 rpm"));
  of_test("--shortest-min", options.shortest_min, "least time at one speed, min")
      ->capture_default_str()
      ->check(finite_range(1.0, 600.0, "1 to 600 min"));
  of_test("--test-load", options.load, "load while the spindle turns, fraction of the rated one")
      ->capture_default_str()
      ->check(finite_range(0.0, 3.0, "0 to 3"));
  of_test("--temporary", options.temporary, "most temporary sensors")->capture_default_str()->check(CLI::Range(0, 12));
  of_test("-o,--output", options.output, "CSV to write: the drive cycle, as simulate reads it");
}

}  // namespace

void add_identify(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "identify", "What sensors can tell of heats, joints, films and nose, and where the next one helps most");
  const auto options = std::make_shared<IdentifyOptions>();
  correction::IdentifyOptions& identify = options->identify;
  identify.priors = correction::constant_priors();
  const CLI::Validator factor = finite_range(0.0, 2.0, "0 to 2");
  const CLI::Validator kelvin = finite_range(0.0, 10.0, "0 to 10 K");
  command->add_option("network", options->network, "network file, .rom")->required();
  command
      ->add_option("--sensors", options->sensors,
                   "key points, parts (their mean) or nodes, with commas between; default: all key points")
      ->delimiter(',');
  command->add_option("--schedule", options->schedule, "drive cycle, CSV; default: the described operating state");
  command->add_option("--hours", options->hours, "of the operating state, without a schedule")
      ->capture_default_str()
      ->check(finite_range(0.01, 1000.0, "0.01 to 1000 h"));
  command->add_option("--heat", identify.priors.heat, "prior deviation of ln of each heat")
      ->capture_default_str()
      ->check(factor);
  command->add_option("--heat-common", identify.priors.heat_common, "and of a factor on all heats together")
      ->capture_default_str()
      ->check(factor);
  command->add_option("--contact", identify.priors.contact, "of each contact")->capture_default_str()->check(factor);
  command->add_option("--film", identify.priors.film, "of each film")->capture_default_str()->check(factor);
  command->add_option("--noise-K", identify.noise_K, "of one reading")
      ->capture_default_str()
      ->check(finite_range(1e-4, 10.0, "1e-4 to 10 K"));
  command->add_option("--offset-K", identify.offset_deviation_K, "constant error of each sensor")
      ->capture_default_str()
      ->check(kelvin);
  command->add_option("--floor-K", identify.floor_K, "what the network is wrong at a sensor")
      ->capture_default_str()
      ->check(kelvin);
  command->add_option("--correlation-s", identify.correlation_s, "readings closer than this share one error")
      ->capture_default_str()
      ->check(finite_range(0.0, 3600.0, "0 to 3600 s"));
  command->add_option("--sample-s", identify.sample_s, "between readings")
      ->capture_default_str()
      ->check(finite_range(0.1, 600.0, "0.1 to 600 s"));
  command->add_option("--placements", identify.placements, "further sensors to look for")
      ->capture_default_str()
      ->check(CLI::Range(0, 20));
  command
      ->add_option("--not-on", identify.closed_parts,
                   "parts without room for a further sensor besides those that turn, with commas between")
      ->delimiter(',');
  command->add_flag("--anywhere", options->anywhere, "further sensors on parts that turn, too");
  add_test_options(*command, *options);
  command->add_option("--html", options->page, "write a page: section with sensors, and where the next one helps");
  command->add_flag("--json", options->json, "as JSON");
  command->callback([options] { run_identify(*options); });
}

}  // namespace spindle_twin::host_tools

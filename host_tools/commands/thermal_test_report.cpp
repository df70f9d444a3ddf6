#include <spdlog/fmt/fmt.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/commands/plausibility.hpp"
#include "host_tools/pages/fill_page.hpp"
#include "host_tools/pages/page_texts.hpp"
#include "host_tools/replay/plan.hpp"
#include "host_tools/replay/predicted_course.hpp"
#include "host_tools/thermal_report/thermal_report.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/units.hpp"

// spindle-twin thermal-test-report warm_up.csv --rom reference.rom -o report.html
namespace spindle_twin::host_tools {
namespace {

struct ReportCommand {
  std::string log;
  ReplayOptions replay;
  std::vector<std::string> notes;
  std::string output;
  bool json = false;
  Plausibility plausibility;
};

/// Reading minus what the replay had said of it before.
Compensated replayed(const ReportCommand& command, const ThermalRecord& record, SetUp& set_up) {
  if (command.replay.network.empty()) return {};
  const rom::Network network = rom::read_network(command.replay.network);
  const Log log = read_log(command.log, network, command.replay.longest_gap_s);
  Plausibility plausibility = command.plausibility;
  plausibility.note_log(log, network);
  plausibility.note_measured(log, network);
  const firmware::CyclePlan plan = plan_replay(network, log, command.replay);
  const PredictedCourses courses = predicted_courses(network, plan, log);
  Compensated compensated;
  compensated.by = fmt::format("{} with {}{}", command.replay.network, law_of(plan),
                               command.replay.calibration.empty() ? "" : " and " + command.replay.calibration);
  for (std::size_t d = 0; d < network.deformations.size(); ++d) {
    if (plan.probes[d].configured) compensated.by += ", which reads the probe at " + network.deformations[d].name;
  }
  for (const Course& length : record.lengths) {
    const auto predicted = std::find_if(courses.deformations.begin(), courses.deformations.end(),
                                        [&](const PredictedCourse& course) { return course.name == length.name; });
    if (predicted == courses.deformations.end()) continue;
    Course left{length.name, {}, {}};
    for (std::size_t i = 0; i < length.time_s.size(); ++i) {
      const double predicted_m = predicted_at(courses, predicted->value, length.time_s[i]);
      if (!std::isfinite(predicted_m)) continue;
      left.time_s.push_back(length.time_s[i]);
      left.value.push_back(length.value[i] - rom::um_per_m * predicted_m);
    }
    if (!left.value.empty()) compensated.left.push_back(std::move(left));
  }
  set_up.emplace_back("spindle", network.spindle);
  return compensated;
}

/// What the log says of the set-up, then what the person says.
SetUp set_up_of(const ReportCommand& command, const ThermalRecord& record) {
  SetUp set_up{{"log", record.file}};
  const auto names = [](const std::vector<Course>& courses) {
    std::string list;
    for (const Course& course : courses) list.append(list.empty() ? "" : ", ").append(course.name);
    return list.empty() ? std::string("none") : list;
  };
  set_up.emplace_back("displacements", names(record.lengths));
  set_up.emplace_back("temperatures", names(record.temperatures));
  set_up.emplace_back("surroundings", names(record.surroundings));
  for (const std::string& note : command.notes) {
    const std::size_t equals = note.find('=');
    set_up.emplace_back(note.substr(0, equals), note.substr(equals + 1));
  }
  return set_up;
}

std::string check_note(const std::string& text) {
  const std::size_t equals = text.find('=');
  return equals == 0 || equals == std::string::npos ? "must be NAME=TEXT" : "";
}

void print_table(const nlohmann::ordered_json& report) {
  const auto& rotation = report["rotation"];
  if (rotation.is_null()) {
    std::printf("the spindle never turns in this log\n");
    return;
  }
  std::printf("%-32s %10s %10s %10s %12s   %s\n", "range in um", "15 min", "60 min", "whole", "rate um/h",
              rotation["kind"].get<std::string>().c_str());
  for (const auto& length : rotation["lengths"]) {
    for (const char* of : {"measured", "compensated"}) {
      if (length[of].is_null()) continue;
      std::printf("%-32s", (length["name"].get<std::string>() + ", " + of).c_str());
      for (const char* window : {"first_15_min", "first_60_min", "whole"}) {
        const auto& drift = length[of][window];
        drift.is_null() ? std::printf(" %10s", "-") : std::printf(" %10.2f", drift["range"].get<double>());
      }
      const auto& whole = length[of]["whole"];
      whole.is_null() ? std::printf(" %12s\n", "-") : std::printf(" %12.2f\n", whole["rate_per_h"].get<double>());
    }
  }
}

void run_report(const ReportCommand& command) {
  if (!command.output.empty()) rom::check_writable(command.output, "--output");
  const ThermalRecord record = read_thermal_record(command.log);
  SetUp set_up;
  const Compensated compensated = replayed(command, record, set_up);
  for (auto& entry : set_up_of(command, record)) set_up.push_back(std::move(entry));
  nlohmann::ordered_json report = thermal_report_json(record, compensated, set_up);
  if (!command.output.empty()) rom::write_whole_file(command.output, fill_page(thermal_test_page_text, report));
  if (command.json) {
    report.erase("courses");
    std::printf("%s\n", report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  } else {
    print_table(report);
  }
}

}  // namespace

void add_thermal_test_report(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "thermal-test-report", "A thermal test after ISO 230-3 in numbers and curves: one page, to read and to print");
  const auto options = std::make_shared<ReportCommand>();
  command
      ->add_option("log", options->log,
                   "CSV: time_s, speed_rpm, measured.<name>_um, and as there are measured.<name>_degC, ambient_degC, "
                   "coolant_degC")
      ->required();
  CLI::Option* rom = command->add_option("--rom", options->replay.network,
                                         "network that the log is replayed with: what its compensation leaves");
  const auto of_replay = [&](const char* name, auto& value, const char* words) {
    return command->add_option(name, value, words)->needs(rom);
  };
  of_replay("--correction", options->replay.correction, "none, paper or estimator")
      ->check(CLI::IsMember({"none", "paper", "estimator"}));
  of_replay("--config", options->replay.config, "the daemon's configuration");
  of_replay("--calibration", options->replay.calibration, "that the estimator begins with");
  of_replay("--sensors", options->replay.sensors, "key points that the correction is given, with commas between")
      ->delimiter(',');
  of_replay("--start-degC", options->replay.start_degC, "of the whole spindle; else the sensors' mean")
      ->check(finite_range(-50.0, 300.0, "-50 to 300 degC"));
  of_replay("--longest-gap-s", options->replay.longest_gap_s, "between two rows of a log")
      ->capture_default_str()
      ->check(finite_range(0.01, 1e6, "0.01 to 1e6 s"));
  command
      ->add_option("--note", options->notes, "NAME=TEXT for the set-up: machine, probe, who made it; may be repeated")
      ->check(CLI::Validator(check_note, "NAME=TEXT"));
  command->add_option("-o,--output", options->output, "page to write");
  command->add_flag("--json", options->json, "the numbers as JSON");
  options->plausibility.add_to(*command);
  command->callback([options] { run_report(*options); });
}

}  // namespace spindle_twin::host_tools

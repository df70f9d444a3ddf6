#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <array>
#include <cstdio>
#include <ctime>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "correction/growth/judge_growth.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/evaluate/growth_reading.hpp"
#include "rom/units.hpp"

// spindle-twin evaluate twin.sqlite --measured parts.csv
namespace spindle_twin::host_tools {
namespace {

using Json = nlohmann::ordered_json;
using correction::applied_as;
using correction::AppliedAs;
using correction::GrowthJudgement;
using correction::GrowthReading;
using correction::GrowthWeek;
using correction::Verdict;
constexpr int worse_exit_code = 3;
constexpr double ever = std::numeric_limits<double>::infinity();

struct EvaluateOptions {
  std::string history;
  std::string measured;
  std::string output;
  bool json = false;
};

struct Evaluation {
  GrowthHistory history;
  std::vector<GrowthWeek> weeks;  ///< those with readings; none without dates
  GrowthJudgement whole;
  std::optional<double> scale;
};

const char* word(AppliedAs applied) {
  switch (applied) {
    case AppliedAs::as_published:
      return "as published";
    case AppliedAs::not_at_all:
      return "not at all: switched off, or not read by the control";
    case AppliedAs::wrong_sign:
      return "with the wrong sign: see compensation.sign";
    case AppliedAs::wrong_scale:
      return "in a wrong scale: see the control's unit";
    default:
      return "cannot be told";
  }
}

Evaluation evaluate(const EvaluateOptions& options) {
  std::vector<HandReading> by_hand;
  if (!options.measured.empty()) by_hand = read_hand_readings(options.measured);
  Evaluation result;
  result.history = read_growth_history(options.history, options.output, by_hand, options.measured);
  const std::vector<GrowthReading>& readings = result.history.readings;
  result.whole = judge_growth(readings, -ever, ever);
  result.scale = applied_scale(readings);
  if (result.history.has_clock) result.weeks = judge_weeks(readings);
  return result;
}

std::string date_of(const GrowthWeek& week) {
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(static_cast<std::time_t>(week.from_unix_s)));
}

Json json_of(const GrowthJudgement& judged) {
  return {{"readings", judged.readings},
          {"growth_rms_um", judged.growth_rms_m * rom::um_per_m},
          {"growth_worst_um", judged.growth_worst_m * rom::um_per_m},
          {"left_rms_um", judged.left_rms_m * rom::um_per_m},
          {"left_worst_um", judged.left_worst_m * rom::um_per_m},
          {"verdict", name_of(judged.verdict)}};
}

void print_json(const Evaluation& result) {
  Json json{{"output", result.history.output}, {"stretches", result.history.stretches}};
  json["weeks"] = Json::array();
  for (const GrowthWeek& week : result.weeks) {
    json["weeks"].push_back(json_of(week.judged));
    json["weeks"].back()["from"] = date_of(week);
  }
  json["whole"] = json_of(result.whole);
  json["applied_times"] = result.scale ? Json(*result.scale) : Json();
  json["applied"] = word(applied_as(result.scale));
  std::printf("%s\n", json.dump(2).c_str());
}

void print_line(const std::string& name, const GrowthJudgement& judged) {
  std::array<char, 16> left{"-"};  // where nothing has grown
  if (judged.growth_rms_m > 0.0) {
    std::snprintf(left.data(), left.size(), "%.2f", judged.left_rms_m / judged.growth_rms_m);
  }
  std::printf("%-12s %8zu %10.2f %10.2f %10.2f %10.2f %8s  %s\n", name.c_str(), judged.readings,
              judged.growth_rms_m * rom::um_per_m, judged.growth_worst_m * rom::um_per_m,
              judged.left_rms_m * rom::um_per_m, judged.left_worst_m * rom::um_per_m, left.data(),
              name_of(judged.verdict));
}

void print_table(const EvaluateOptions& options, const Evaluation& result) {
  std::printf("%s of %s: %zu readings in %zu stretches between starts and tares; the first of each is its zero\n\n",
              result.history.output.c_str(), options.history.c_str(), result.history.readings.size(),
              result.history.stretches);
  if (result.whole.readings == 0) {
    std::printf(
        "nothing to judge: two touch-offs or readings by hand in one stretch are needed; a log with a probe is judged "
        "by\n"
        "spindle-twin thermal-test-report LOG --rom X.rom\n");
    return;
  }
  std::printf("%-12s %8s %10s %10s %10s %10s %8s\n", "week from", "readings", "growth rms", "worst um", "left rms",
              "worst um", "left");
  for (const GrowthWeek& week : result.weeks) print_line(date_of(week), week.judged);
  print_line("all", result.whole);
  if (result.scale) {
    std::printf("\nthe control applies %.2f times what is published: %s\n", *result.scale,
                word(applied_as(result.scale)));
  }
}

void run_evaluate(const EvaluateOptions& options) {
  const Evaluation result = evaluate(options);
  options.json ? print_json(result) : print_table(options, result);
  const GrowthJudgement& latest = result.weeks.empty() ? result.whole : result.weeks.back().judged;
  if (result.whole.verdict != Verdict::makes_worse && latest.verdict != Verdict::makes_worse) return;
  std::fprintf(stderr, "spindle-twin: %s: the compensation of %s makes it worse; check sign, unit and network\n",
               options.history.c_str(), result.history.output.c_str());
  throw CLI::RuntimeError(worse_exit_code);
}

}  // namespace

void add_evaluate(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "evaluate",
      "Does it help? Measured growth with and without compensation, week by week; exit code 3: it does not");
  const auto options = std::make_shared<EvaluateOptions>();
  command->add_option("history", options->history, "history of spindle-twind, SQLite or CSV, with its touch-offs")
      ->required();
  command->add_option("--measured", options->measured,
                      "CSV of what was measured by hand: time_utc, growth_um and, for parts, compensated (0 or 1)");
  command->add_option("--output", options->output, "which deformation; else the first, the nose");
  command->add_flag("--json", options->json, "as JSON");
  command->callback([options] { run_evaluate(*options); });
}

}  // namespace spindle_twin::host_tools

#include "firmware/run/growth_page.hpp"

#include <spdlog/fmt/fmt.h>

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "correction/growth/judge_growth.hpp"
#include "firmware/keep/sqlite_history.hpp"
#include "firmware/run/pace.hpp"
#include "firmware/show/json_text.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr double ever = std::numeric_limits<double>::infinity();

std::string members(const correction::GrowthJudgement& judged) {
  using rom::um_per_m;
  return fmt::format(
      "\"readings\":{},\"growth_rms_um\":{:.3f},\"growth_worst_um\":{:.3f},\"left_rms_um\":{:.3f},"
      "\"left_worst_um\":{:.3f},\"verdict\":{}",
      judged.readings, judged.growth_rms_m * um_per_m, judged.growth_worst_m * um_per_m, judged.left_rms_m * um_per_m,
      judged.left_worst_m * um_per_m, json_text(name_of(judged.verdict)));
}

std::string number(std::optional<double> value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : "null";
}

std::string output_json(const OutputTouchOffs& output) {
  const std::vector<correction::GrowthReading>& readings = output.readings;
  std::string weeks;
  for (const correction::GrowthWeek& week : judge_weeks(readings)) {
    weeks += fmt::format("{}{{\"from_unix_s\":{:.0f},{}}}", weeks.empty() ? "" : ",", week.from_unix_s,
                         members(week.judged));
  }
  const auto first_s = readings.empty() ? std::nullopt : std::optional(readings.front().unix_s);
  return fmt::format(
      "{{\"output\":{},\"touch_offs\":{},\"stretches\":{},\"from_unix_s\":{},\"measured_times\":{},"
      "\"whole\":{{{}}},\"weeks\":[{}]}}",
      json_text(output.output), readings.size(), output.stretches, number(first_s, 0),
      number(measured_times(readings), 3), members(judge_growth(readings, -ever, ever)), weeks);
}

}  // namespace

std::string growth_json(const FoundTouchOffs& found) {
  std::string outputs;
  for (const OutputTouchOffs& output : found.outputs) {
    outputs.append(outputs.empty() ? "" : ",").append(output_json(output));
  }
  return fmt::format("{{\"is_whole\":{},\"outputs\":[{}]}}", found.is_whole, outputs);
}

std::function<Page(const std::atomic<bool>& stop)> growth_page(const HistoryPlan& plan, const rom::Network& network) {
  if (!is_sqlite_path(plan.path) || network.deformations.empty()) return {};
  std::vector<std::string> outputs;
  for (const rom::DeformationOutput& deformation : network.deformations) outputs.push_back(deformation.name);
  const auto history = std::make_shared<TouchOffHistory>(plan.path, outputs);
  return [history](const std::atomic<bool>& stop) -> Page {
    Pace pace(stop);
    return {200, "application/json", growth_json(history->read([&pace] { return pace.go_on(); })) + "\n"};
  };
}

}  // namespace spindle_twin::firmware

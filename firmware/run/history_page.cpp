#include "firmware/run/history_page.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "firmware/keep/sqlite_history.hpp"
#include "firmware/run/pace.hpp"
#include "firmware/show/json_text.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {
namespace {

void add_list(std::string& json, const char* name, const std::vector<float>& values) {
  json += fmt::format("\"{}\":[", name);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) json += ',';
    if (std::isfinite(values[i])) {
      fmt::format_to(std::back_inserter(json), "{:.3f}", values[i]);
    } else {
      json += "null";
    }
  }
  json += ']';
}

}  // namespace

std::vector<std::string> shown_columns(const rom::Network& network) {
  std::vector<std::string> columns;
  if (!network.deformations.empty()) {
    columns = {"nose_um", "nose_uncorrected_um", "deformation_sd." + network.deformations[0].name + "_um"};
  }
  for (const rom::KeyPoint& point : network.key_points) {
    for (const char* kind : {"measured.", "predicted."}) columns.push_back(kind + point.name + "_degC");
    columns.push_back("predicted_sd." + point.name + "_K");
  }
  return columns;
}

std::string thinned_json(int hours, const ThinnedHours& thinned) {
  std::string json =
      fmt::format("{{\"hours\":{},\"span_s\":{},\"is_whole\":{},\"unix_s\":[", hours, thinned.span_s, thinned.is_whole);
  for (std::size_t i = 0; i < thinned.unix_s.size(); ++i) {
    json += fmt::format("{}{:.1f}", i > 0 ? "," : "", thinned.unix_s[i]);
  }
  json += "],\"columns\":{";
  bool is_first = true;
  for (const ThinnedColumn& column : thinned.columns) {
    json.append(std::exchange(is_first, false) ? "" : ",").append(json_text(column.name)).append(":{");
    add_list(json, "min", column.least);
    json += ',';
    add_list(json, "mean", column.mean);
    json += ',';
    add_list(json, "max", column.greatest);
    json += '}';
  }
  return json + "}}";
}

std::function<Page(int hours, const std::atomic<bool>& stop)> history_page(const HistoryPlan& plan,
                                                                           const rom::Network& network) {
  if (!is_sqlite_path(plan.path)) return {};
  const auto history = std::make_shared<ThinnedHistory>(plan.path, shown_columns(network));
  return [history](int hours, const std::atomic<bool>& stop) -> Page {
    Pace pace(stop);
    const ThinnedHours thinned = history->read(hours, unix_now_s(), [&pace] { return pace.go_on(); });
    return {200, "application/json", thinned_json(hours, thinned) + "\n"};
  };
}

}  // namespace spindle_twin::firmware

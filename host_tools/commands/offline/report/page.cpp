#include "host_tools/commands/offline/report/page.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "host_tools/pages/fill_page.hpp"
#include "host_tools/pages/page_texts.hpp"

namespace spindle_twin::host_tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_points = 4000;  // what a screen shows; longer runs are thinned

Json thinned(const std::vector<double>& values, std::size_t every, double digits) {
  Json list = Json::array();
  for (std::size_t i = 0; i < values.size(); i += every) {
    if (std::isfinite(values[i])) {
      list.push_back(std::round(values[i] * digits) / digits);
    } else {
      list.push_back(nullptr);
    }
  }
  return list;
}

Json as_json(const Quantity& quantity, std::size_t every) {
  constexpr double digits = 1e4;
  return {{"name", quantity.name},
          {"zero", quantity.zero},
          {"measured", thinned(quantity.measured, every, digits)},
          {"plant", thinned(quantity.plant, every, digits)},
          {"twin", thinned(quantity.twin, every, digits)},
          {"twin_sd", thinned(quantity.twin_sd, every, digits)},
          {"uncorrected", thinned(quantity.uncorrected, every, digits)}};
}

/// The last row of the run as text cells.
struct TableRow {
  std::string name, unit;
  double uncorrected, twin, plant;
  double twin_sd;  ///< NaN where the history has none

  double share_percent() const { return 100.0 * (twin - plant) / plant; }
};

std::vector<TableRow> last_row(const RunData& run) {
  std::vector<TableRow> rows;
  const auto add = [&](const Quantity& quantity, const std::string& name, const std::string& unit) {
    rows.push_back({name, unit, quantity.uncorrected.back() - quantity.zero, quantity.twin.back() - quantity.zero,
                    quantity.plant.back() - quantity.zero,
                    quantity.twin_sd.empty() ? std::numeric_limits<double>::quiet_NaN() : quantity.twin_sd.back()});
  };
  for (const Quantity& point : run.key_points) add(point, "key point " + point.name, "K");
  add(run.hottest, run.hottest.name + ", maximum", "K");
  add(run.nose, run.nose.name + ", elongation", "um");
  return rows;
}

std::string formatted(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string formatted(const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

Json table_json(const RunData& run) {
  Json rows = Json::array();
  for (const TableRow& row : last_row(run)) {
    rows.push_back({{"name", row.name},
                    {"unit", row.unit == "um" ? "µm" : row.unit},
                    {"uncorrected", row.uncorrected},
                    {"twin", row.twin},
                    {"plant", row.plant},
                    {"twin_sd", std::isnan(row.twin_sd) ? Json() : Json(row.twin_sd)}});
  }
  return rows;
}

}  // namespace

std::string run_table(const RunData& run) {
  std::string text = formatted("simulated spindle '%s' after %.0f s at %.0f rpm, ambient %.1f degC: rises\n",
                               run.spindle.c_str(), run.time_s.back(), run.speed_rpm, run.ambient_degC);
  text += formatted("%-24s %-4s %12s %10s %10s %18s %14s %10s %16s\n", "quantity", "unit", "uncorrected", "twin",
                    "plant", "uncorrected error", "twin error", "of rise", "2 sigma of twin");
  for (const TableRow& row : last_row(run)) {
    text +=
        formatted("%-24s %-4s %12.2f %10.2f %10.2f %+18.2f %+14.2f %+9.1f%% %16s\n", row.name.c_str(), row.unit.c_str(),
                  row.uncorrected, row.twin, row.plant, row.uncorrected - row.plant, row.twin - row.plant,
                  row.share_percent(), std::isnan(row.twin_sd) ? "-" : formatted("%.2f", 2.0 * row.twin_sd).c_str());
  }
  return text;
}

std::string run_page(const RunData& run) {
  const std::size_t every = 1 + run.time_s.size() / most_points;
  Json data{{"spindle", run.spindle},
            {"speed_rpm", run.speed_rpm},
            {"ambient_degC", run.ambient_degC},
            {"coolant_degC", run.coolant_degC},
            {"time_s", thinned(run.time_s, every, 1e3)},
            {"end_s", run.time_s.back()},
            {"key_points", Json::array()},
            {"hottest", as_json(run.hottest, every)},
            {"nose", as_json(run.nose, every)},
            {"factors", Json::array()},
            {"section", {{"outlines", run.outlines}, {"parts", Json::array()}}},
            {"table", table_json(run)}};
  for (std::size_t k = 0; k < run.key_points.size(); ++k) {
    data["key_points"].push_back(as_json(run.key_points[k], every));
    data["key_points"][k]["at_m"] = run.key_point_places_m[k];
  }
  for (std::size_t f = 0; f < run.heat_factors.size(); ++f) {
    data["factors"].push_back({{"name", run.factor_names[f]}, {"values", thinned(run.heat_factors[f], every, 1e5)}});
  }
  for (const PartRises& part : run.part_rises) {
    data["section"]["parts"].push_back({{"name", part.name}, {"rises_K", thinned(part.rises_K, every, 1e2)}});
  }
  return fill_page(run_page_text, data);
}

}  // namespace spindle_twin::host_tools

#include "host_tools/commands/offline/report/page.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host_tools/commands/offline/report/page_template.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr std::size_t most_points = 4000;  // what a screen shows; longer runs are thinned

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw rom::InputError({path, 0}, "--dygraphs", "cannot be read; the Debian package libjs-dygraphs brings it");
  }
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void replace(std::string& text, const std::string& mark, const std::string& by) {
  const std::size_t place = text.find(mark);
  if (place != std::string::npos) text.replace(place, mark.size(), by);
}

/// Inside a script element the text must not close it.
std::string script_safe(const std::string& text) {
  std::string safe;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 3, "</s") == 0) {
      safe += "<\\/";
      ++i;
    } else {
      safe += text[i];
    }
  }
  return safe;
}

nlohmann::json thinned(const std::vector<double>& values, std::size_t every, double digits) {
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t i = 0; i < values.size(); i += every) {
    if (std::isfinite(values[i])) {
      list.push_back(std::round(values[i] * digits) / digits);
    } else {
      list.push_back(nullptr);
    }
  }
  return list;
}

nlohmann::json as_json(const Quantity& quantity, std::size_t every) {
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

std::string run_page(const RunData& run, const std::string& dygraphs_folder) {
  const std::size_t every = 1 + run.time_s.size() / most_points;
  nlohmann::json data{{"spindle", run.spindle},
                      {"speed_rpm", run.speed_rpm},
                      {"ambient_degC", run.ambient_degC},
                      {"coolant_degC", run.coolant_degC},
                      {"time_s", thinned(run.time_s, every, 1e3)},
                      {"end_s", run.time_s.back()},
                      {"key_points", nlohmann::json::array()},
                      {"hottest", as_json(run.hottest, every)},
                      {"nose", as_json(run.nose, every)},
                      {"factor_names", run.factor_names},
                      {"heat_factors", nlohmann::json::array()},
                      {"table", nlohmann::json::array()}};
  for (const Quantity& point : run.key_points) data["key_points"].push_back(as_json(point, every));
  for (const std::vector<double>& factor : run.heat_factors)
    data["heat_factors"].push_back(thinned(factor, every, 1e5));
  for (const TableRow& row : last_row(run)) {
    data["table"].push_back({row.name, row.unit == "um" ? "µm" : row.unit, row.uncorrected, row.twin, row.plant,
                             std::isnan(row.twin_sd) ? nlohmann::json(nullptr) : nlohmann::json(row.twin_sd)});
  }
  std::string page = page_template;
  replace(page, "@DYGRAPHS_CSS@", read_text(dygraphs_folder + "/dygraph.min.css"));
  replace(page, "@DYGRAPHS_JS@", script_safe(read_text(dygraphs_folder + "/dygraph.min.js")));
  replace(page, "@SYNCHRONIZER_JS@", script_safe(read_text(dygraphs_folder + "/extras/synchronizer.js")));
  replace(page, "@DATA@", script_safe(data.dump()));
  return page;
}

}  // namespace spindle_twin::host_tools

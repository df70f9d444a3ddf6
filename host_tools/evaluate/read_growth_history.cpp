#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include "correction/growth/touch_offs.hpp"
#include "firmware/keep/read_sqlite_history.hpp"
#include "host_tools/evaluate/growth_reading.hpp"
#include "rom/read/csv_table.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

// Steps: find the columns; walk through the rows of each run, of which TouchOffs finds the touch-offs; give each
// reading by hand the last row before its time.
namespace spindle_twin::host_tools {
namespace {

constexpr double longest_before_s = 60.0;  // from the cycle to a reading by hand
constexpr double s_per_ns = 1e-9;

/// Where a history's row has what is asked here.
struct GrowthColumns {
  GrowthColumns(const std::vector<std::string>& names, const std::string& file, const std::string& asked) {
    const std::string prefix = "deformation.", unit = "_um";
    std::vector<std::string> outputs;
    for (const std::string& name : names) {
      if (!name.starts_with(prefix) || !name.ends_with(unit)) continue;
      outputs.push_back(name.substr(prefix.size(), name.size() - prefix.size() - unit.size()));
    }
    if (outputs.empty()) throw rom::InputError({file, 0}, "", "is no history of spindle-twind with deformations");
    const auto found = asked.empty() ? outputs.begin() : std::find(outputs.begin(), outputs.end(), asked);
    if (found == outputs.end()) {
      throw rom::InputError({file, 0}, "--output",
                            fmt::format("has no {}; it has {}", asked, fmt::join(outputs, ", ")));
    }
    output = *found;
    slot = static_cast<std::size_t>(found - outputs.begin());
    const auto column = [&](const std::string& name) {
      const auto at = std::find(names.begin(), names.end(), name);
      if (at == names.end()) throw rom::InputError({file, 0}, name, "no such column: no history of spindle-twind");
      return static_cast<std::size_t>(at - names.begin());
    };
    predicted = column(prefix + output + unit);
    tare = column("tare_um");
    tares = column("tare_count");
    orders = column("length_orders");
    of_output = column("length_output");
    length = column("length_m");
    deviation = column("length_sd_m");
    clock = column("clock_ns");
  }
  std::string output;
  std::size_t slot = 0, predicted = 0, tare = 0, tares = 0, orders = 0, of_output = 0, length = 0, deviation = 0,
              clock = 0;
};

/// Goes along with the rows of one history.
class GrowthWalk {
 public:
  GrowthWalk(const GrowthColumns& columns, const std::vector<HandReading>& by_hand, GrowthHistory& history)
      : columns_(columns),
        by_hand_(by_hand),
        order_(by_hand.size()),
        matched_(by_hand.size(), false),
        out_(history),
        touch_offs_(columns.slot) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return by_hand[a].unix_s < by_hand[b].unix_s; });
  }

  /// Readings by hand up to the first row of this run belong to the run before.
  void begin_run(double first_unix_s) {
    match_last_minute(first_unix_s);
    first_unix_s_ = first_unix_s;
    touch_offs_.begin_run();
    next_hand_ = 0;
  }

  void row(std::span<const double> values) {
    if (!touch_offs_.before()) first_clock_ns_ = values[columns_.clock];
    const double unix_s = first_unix_s_ + s_per_ns * (values[columns_.clock] - first_clock_ns_);
    match_until(unix_s);
    const double tare_m = columns_.slot == 0 ? values[columns_.tare] * rom::m_per_um : 0.0;
    const auto reading = touch_offs_.row({unix_s, values[columns_.predicted] * rom::m_per_um - tare_m,
                                          values[columns_.tares], values[columns_.orders], values[columns_.of_output],
                                          values[columns_.length], values[columns_.deviation]});
    out_.stretches = touch_offs_.stretches();
    if (reading) out_.readings.push_back(*reading);
  }

  void end() { match_last_minute(std::numeric_limits<double>::infinity()); }

  void check_all_matched(const std::string& hand_file) const {
    for (std::size_t i = 0; i < by_hand_.size(); ++i) {
      if (matched_[i]) continue;
      throw rom::InputError({hand_file, by_hand_[i].line}, "time_utc",
                            "the history has no prediction in the minute before this time");
    }
  }

 private:
  /// Of the run that has ended, as far as the next one has not begun.
  void match_last_minute(double next_unix_s) {
    if (touch_offs_.before()) match_until(std::min(next_unix_s, touch_offs_.before()->unix_s + longest_before_s));
  }

  /// Readings by hand before `unix_s` belong to the row before, each to the first run that has one.
  void match_until(double unix_s) {
    const std::optional<correction::GrowthRow>& before = touch_offs_.before();
    for (; next_hand_ < order_.size() && by_hand_[order_[next_hand_]].unix_s < unix_s; ++next_hand_) {
      const HandReading& hand = by_hand_[order_[next_hand_]];
      const double since_s = before ? hand.unix_s - before->unix_s : -1.0;
      if (matched_[order_[next_hand_]] || since_s < 0.0 || since_s > longest_before_s) continue;
      if (!std::isfinite(before->published_m)) continue;
      matched_[order_[next_hand_]] = true;
      const auto origin =
          hand.compensated ? correction::ReadingOrigin::by_hand_compensated : correction::ReadingOrigin::by_hand;
      out_.readings.push_back({hand.unix_s, touch_offs_.stretches() - 1, origin, hand.growth_m, before->published_m});
    }
  }

  const GrowthColumns& columns_;
  const std::vector<HandReading>& by_hand_;
  std::vector<std::size_t> order_;  ///< of the readings by hand, by time
  std::vector<bool> matched_;
  GrowthHistory& out_;
  correction::TouchOffs touch_offs_;
  std::size_t next_hand_ = 0;
  double first_unix_s_ = 0.0, first_clock_ns_ = 0.0;
};

void walk_csv(GrowthWalk& walk, const rom::CsvTable& table) {
  std::vector<double> values(table.columns.size());
  walk.begin_run(table.column("time_s")[0]);
  for (std::size_t r = 0; r < table.rows(); ++r) {
    for (std::size_t c = 0; c < values.size(); ++c) values[c] = table.columns[c][r];
    walk.row(values);
  }
  walk.end();
}

}  // namespace

GrowthHistory read_growth_history(const std::string& path, const std::string& output,
                                  const std::vector<HandReading>& by_hand, const std::string& hand_file) {
  GrowthHistory history;
  history.has_clock = firmware::is_sqlite_file(path);
  if (!history.has_clock) {
    if (!by_hand.empty()) {
      throw rom::InputError({path, 0}, "", "has no dates; readings by hand need a history in SQLite");
    }
    const rom::CsvTable table = rom::read_csv_table(path, rom::LastLine::may_be_cut);
    const GrowthColumns columns(table.names, path, output);
    history.output = columns.output;
    GrowthWalk walk(columns, by_hand, history);
    walk_csv(walk, table);
    return history;
  }
  const firmware::SqliteHistoryReader file(path);
  const GrowthColumns columns(file.columns(), path, output);
  history.output = columns.output;
  GrowthWalk walk(columns, by_hand, history);
  for (const firmware::HistoryRun& run : file.runs()) {
    walk.begin_run(run.first_unix_s);
    file.each_row(run.id, [&](std::span<const double> values) { walk.row(values); });
  }
  walk.end();
  walk.check_all_matched(hand_file);
  return history;
}

}  // namespace spindle_twin::host_tools

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <span>

#include "firmware/keep/read_sqlite_history.hpp"
#include "host_tools/evaluate/growth_reading.hpp"
#include "rom/read/csv_table.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

// Steps: find the columns; walk through the rows of each run; where the PLC handed over a length, take the row before
// as what the twin had said without it; give each reading by hand the last row before its time.
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
    clock = column("clock_ns");
  }
  std::string output;
  std::size_t slot = 0, predicted = 0, tare = 0, tares = 0, orders = 0, of_output = 0, length = 0, clock = 0;
};

/// Goes along with the rows of one history.
class GrowthWalk {
 public:
  GrowthWalk(const GrowthColumns& columns, const std::vector<HandReading>& by_hand, GrowthHistory& history)
      : columns_(columns), by_hand_(by_hand), order_(by_hand.size()), matched_(by_hand.size(), false), out_(history) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return by_hand[a].unix_s < by_hand[b].unix_s; });
  }

  void begin_run(double first_unix_s) {
    first_unix_s_ = first_unix_s;
    before_.reset();
    next_hand_ = 0;
  }

  void row(std::span<const double> values) {
    if (!before_) {
      first_clock_ns_ = values[columns_.clock];
      ++out_.stretches;
    } else if (values[columns_.tares] != before_->tares) {
      ++out_.stretches;
    }
    const double unix_s = first_unix_s_ + s_per_ns * (values[columns_.clock] - first_clock_ns_);
    match_until(unix_s);
    const double tare_m = columns_.slot == 0 ? values[columns_.tare] * rom::m_per_um : 0.0;
    const double predicted_m = values[columns_.predicted] * rom::m_per_um - tare_m;
    const bool touched = before_ && values[columns_.orders] > before_->orders &&
                         static_cast<std::size_t>(values[columns_.of_output]) == columns_.slot &&
                         values[columns_.tares] == before_->tares;
    if (touched && std::isfinite(before_->predicted_m)) {
      add(unix_s, ReadingOrigin::touch_off, values[columns_.length], before_->predicted_m);
    }
    before_ = Before{unix_s, predicted_m, values[columns_.tares], values[columns_.orders]};
  }

  void end_run() {
    if (before_) match_until(before_->unix_s + longest_before_s);
  }

  void check_all_matched(const std::string& hand_file) const {
    for (std::size_t i = 0; i < by_hand_.size(); ++i) {
      if (matched_[i]) continue;
      throw rom::InputError({hand_file, by_hand_[i].line}, "time_utc",
                            "the history has no prediction in the minute before this time");
    }
  }

 private:
  struct Before {
    double unix_s, predicted_m, tares, orders;
  };

  void add(double unix_s, ReadingOrigin origin, double measured_m, double predicted_m) {
    if (!std::isfinite(measured_m)) return;
    out_.readings.push_back({unix_s, out_.stretches - 1, origin, measured_m, predicted_m});
  }

  /// Readings by hand before `unix_s` belong to the row before.
  void match_until(double unix_s) {
    for (; next_hand_ < order_.size() && by_hand_[order_[next_hand_]].unix_s < unix_s; ++next_hand_) {
      const std::size_t hand = order_[next_hand_];
      const double since_s = before_ ? by_hand_[hand].unix_s - before_->unix_s : -1.0;
      if (since_s < 0.0 || since_s > longest_before_s || !std::isfinite(before_->predicted_m)) continue;
      matched_[hand] = true;
      add(by_hand_[hand].unix_s,
          by_hand_[hand].compensated ? ReadingOrigin::by_hand_compensated : ReadingOrigin::by_hand,
          by_hand_[hand].growth_m, before_->predicted_m);
    }
  }

  const GrowthColumns& columns_;
  const std::vector<HandReading>& by_hand_;
  std::vector<std::size_t> order_;  ///< of the readings by hand, by time
  std::vector<bool> matched_;
  GrowthHistory& out_;
  std::optional<Before> before_;
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
  walk.end_run();
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
    walk.end_run();
  }
  walk.check_all_matched(hand_file);
  return history;
}

}  // namespace spindle_twin::host_tools

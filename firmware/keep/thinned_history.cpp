#include "firmware/keep/thinned_history.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr double rows_come_within_s = 60.0;  ///< a row has its time when it is written, and is then readable
constexpr std::int64_t rows_between_rests = 100;
constexpr int columns_before = 2;  ///< unix_s and run
constexpr auto no_value = std::numeric_limits<float>::quiet_NaN();

/// Least, mean and greatest of the numbers that there are.
class Extremes {
 public:
  void add(double value) {
    if (!std::isfinite(value)) return;
    least_ = count_ == 0 ? value : std::min(least_, value);
    greatest_ = count_ == 0 ? value : std::max(greatest_, value);
    sum_ += value;
    ++count_;
  }
  void put(std::vector<float>& values) const {
    const double mean = sum_ / static_cast<double>(count_);
    for (const double value : {least_, mean, greatest_}) {
      values.push_back(count_ == 0 ? no_value : static_cast<float>(value));
    }
  }

 private:
  std::int64_t count_ = 0;
  double least_ = 0.0, sum_ = 0.0, greatest_ = 0.0;
};

void add_moment(ThinnedHours& hours, double unix_s, const std::vector<float>& values) {
  hours.unix_s.push_back(unix_s);
  for (std::size_t c = 0; c < hours.columns.size(); ++c) {
    const auto value = [&](std::size_t which) { return values.empty() ? no_value : values[3 * c + which]; };
    hours.columns[c].least.push_back(value(0));
    hours.columns[c].mean.push_back(value(1));
    hours.columns[c].greatest.push_back(value(2));
  }
}

}  // namespace

ThinnedHistory::ThinnedHistory(std::string path, std::vector<std::string> columns)
    : path_(std::move(path)), columns_(std::move(columns)), select_("SELECT unix_s, run") {
  // With its table: a quoted name that stands alone and is no column would be a text to SQLite.
  for (const std::string& column : columns_) select_.append(", cycle.").append(quoted_name(column));
  select_ += " FROM cycle WHERE unix_s >= ? AND unix_s < ? ORDER BY unix_s";
}

ThinnedHours ThinnedHistory::read(int hours, double now_unix_s, const std::function<bool()>& go_on) {
  const double span_s = hours * rom::seconds_per_hour / most_spans;
  const auto last = static_cast<std::int64_t>(std::floor(now_unix_s / span_s));
  const std::int64_t first = last - most_spans + 1;
  Kept& kept = kept_[hours];
  if (now_unix_s < kept.read_unix_s) kept.spans.clear();  // the clock was set back
  kept.read_unix_s = now_unix_s;
  std::erase_if(kept.spans, [&](const auto& each) { return each.first < first || !each.second.is_final; });
  try {
    const bool is_whole = read_missing(kept, first, last, go_on, span_s);
    ThinnedHours read = told(kept, span_s);
    read.is_whole = is_whole;
    return read;
  } catch (const DatabaseError& error) {
    throw rom::InputError({path_, 0}, "", std::string("cannot be read as a history in SQLite: ") + error.what());
  }
}

/// False where `go_on` ended it.
bool ThinnedHistory::read_missing(Kept& kept, std::int64_t first, std::int64_t last, const std::function<bool()>& go_on,
                                  double span_s) const {
  Database database(path_, Database::Mode::read);
  if (const std::int64_t version = database.whole("PRAGMA user_version"); version > 1) {
    throw rom::InputError({path_, 0}, "user_version", fmt::format("is {}; this program reads 1", version));
  }
  for (std::int64_t number = last; number >= first; --number) {
    if (kept.spans.contains(number)) continue;
    const double from_s = span_s * static_cast<double>(number), to_s = span_s * static_cast<double>(number + 1);
    std::optional<Span> span;
    if (go_on()) span = read_span(database, from_s, to_s, go_on);
    if (!span) return false;
    span->is_final = to_s <= kept.read_unix_s - rows_come_within_s;
    kept.spans.emplace(number, *std::move(span));
  }
  return true;
}

/// Nothing where `go_on` ended it.
std::optional<ThinnedHistory::Span> ThinnedHistory::read_span(Database& database, double from_s, double to_s,
                                                              const std::function<bool()>& go_on) const {
  Statement row = database.prepare(select_);
  row.bind(0, from_s);
  row.bind(1, to_s);
  Span span;
  std::vector<Extremes> columns(columns_.size());
  double sum_s = 0.0;
  while (row.step()) {
    const std::int64_t run = row.whole(1);
    span.first_run = span.rows == 0 ? run : std::min(span.first_run, run);
    span.last_run = std::max(span.last_run, run);
    sum_s += row.number(0) - from_s;
    for (std::size_t c = 0; c < columns.size(); ++c) columns[c].add(row.number(static_cast<int>(c) + columns_before));
    if (++span.rows % rows_between_rests == 0 && !go_on()) return std::nullopt;
  }
  if (span.rows == 0) return span;
  span.unix_s = from_s + sum_s / static_cast<double>(span.rows);
  span.values.reserve(3 * columns.size());
  for (const Extremes& column : columns) column.put(span.values);
  return span;
}

ThinnedHours ThinnedHistory::told(const Kept& kept, double span_s) const {
  ThinnedHours hours;
  hours.span_s = span_s;
  for (const std::string& name : columns_) hours.columns.push_back({name, {}, {}, {}});
  const Span* before = nullptr;
  for (const auto& [number, span] : kept.spans) {
    if (span.rows == 0) continue;
    if (before != nullptr && before->last_run != span.first_run) {
      add_moment(hours, 0.5 * (before->unix_s + span.unix_s), {});
    }
    add_moment(hours, span.unix_s, span.values);
    before = &span;
  }
  return hours;
}

}  // namespace spindle_twin::firmware

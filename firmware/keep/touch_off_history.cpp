#include "firmware/keep/touch_off_history.hpp"

#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "correction/growth/touch_offs.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

// Steps: go through the runs, the newest first; halve what is between two rows of other numbers until they stand behind
// each other; give what was found to TouchOffs, in the order of time.
namespace spindle_twin::firmware {
namespace {

constexpr std::int64_t touch_offs_between_rests = 16;
constexpr int columns_before_outputs = 7;  ///< those of the outputs

}  // namespace

/// One reading of the file.
class TouchOffHistory::Search {
 public:
  Search(TouchOffHistory& owner, const std::function<bool()>& go_on)
      : owner_(owner), go_on_(go_on), database_(owner.path_, Database::Mode::read) {
    if (const std::int64_t version = database_.whole("PRAGMA user_version"); version > 1) {
      throw rom::InputError({owner.path_, 0}, "user_version", fmt::format("is {}; this program reads 1", version));
    }
  }

  /// False where it is not to go on.
  bool all() {
    const std::int64_t first = database_.whole("SELECT min(id) FROM cycle");
    std::int64_t end = database_.whole("SELECT max(id) FROM cycle") + 1;
    const std::uint64_t before = std::exchange(owner_.file_, file_now());
    if (before != owner_.file_) owner_.runs_.clear();
    let_go(first);
    Statement run = database_.prepare("SELECT id FROM run ORDER BY id DESC");
    while (end > first && run.step()) {
      const std::int64_t id = run.whole(0);
      if (id >= end) continue;  // its rows are not written yet
      if (!search(id, std::max(id, first), end - 1)) return false;
      end = id;
      if (owner_.changes() >= most_changes) break;
    }
    return true;
  }

 private:
  /// Which file stands at the path: a damaged one is put aside, and a new one begun.
  std::uint64_t file_now() const {
    struct stat now {};
    return ::stat(owner_.path_.c_str(), &now) == 0 ? now.st_ino : 0;
  }

  /// What is no longer in the file counts no more.
  void let_go(std::int64_t first) const {
    std::erase_if(owner_.runs_, [&](const auto& each) { return first == 0 || each.second.last.id < first; });
    for (auto& [id, run] : owner_.runs_) {
      while (!run.changes.empty() && run.changes.front().before.id < first) begin_later(run);
    }
  }

  /// Behind its first change, which counts no more.
  static void begin_later(Run& run) {
    run.first = std::move(run.changes.front().at);
    run.changes.pop_front();
  }

  std::optional<Row> row(std::int64_t id) {
    if (++rows_ % touch_offs_between_rests == 0 && !go_on_()) return std::nullopt;
    Statement found = database_.prepare(owner_.select_);
    found.bind(0, id);
    if (!found.step()) return std::nullopt;  // the daemon has just let it go
    Row row{id,
            found.number(0),
            found.number(1),
            found.number(2),
            found.number(3),
            found.number(4),
            found.number(5),
            found.number(6) * rom::m_per_um,
            {}};
    for (std::size_t d = 0; d < owner_.outputs_.size(); ++d) {
      row.published_m.push_back(found.number(columns_before_outputs + static_cast<int>(d)) * rom::m_per_um);
    }
    return row;
  }

  bool search(std::int64_t id, std::int64_t first, std::int64_t last) {
    auto known = owner_.runs_.find(id);
    if (known == owner_.runs_.end()) {
      const std::optional<Row> begin = row(first);
      if (!begin) return false;
      known = owner_.runs_.emplace(id, Run{*begin, *begin, {}}).first;
    }
    Run& run = known->second;
    if (run.last.id >= last) return true;
    const std::optional<Row> end = row(last);
    return end && between(run, *end);
  }

  /// Finds the changes from what was searched before up to `end`, and keeps how far it came.
  bool between(Run& run, const Row& end) {
    const bool is_same = run.last.tares == end.tares && run.last.orders == end.orders;
    if (!is_same && run.last.id + 1 == end.id) {
      run.changes.push_back({run.last, end});
      if (run.changes.size() > most_changes) begin_later(run);
    } else if (!is_same) {
      const std::optional<Row> middle = row(run.last.id + (end.id - run.last.id) / 2);
      return middle && between(run, *middle) && between(run, end);
    }
    run.last = end;
    return true;
  }

  TouchOffHistory& owner_;
  const std::function<bool()>& go_on_;
  Database database_;
  std::int64_t rows_ = 0;
};

TouchOffHistory::TouchOffHistory(std::string path, std::vector<std::string> outputs)
    : path_(std::move(path)), outputs_(std::move(outputs)) {
  // With its table: a quoted name that stands alone and is no column would be a text to SQLite.
  select_ =
      "SELECT unix_s, cycle.tare_count, cycle.length_orders, cycle.length_output, cycle.length_m, "
      "cycle.length_sd_m, cycle.tare_um";
  for (const std::string& output : outputs_) {
    select_.append(", cycle.").append(quoted_name("deformation." + output + "_um"));
  }
  select_ += " FROM cycle WHERE id = ?";
}

std::size_t TouchOffHistory::changes() const {
  std::size_t count = 0;
  for (const auto& [id, run] : runs_) count += run.changes.size();
  return count;
}

FoundTouchOffs TouchOffHistory::read(const std::function<bool()>& go_on) {
  try {
    const bool is_whole = Search(*this, go_on).all();
    FoundTouchOffs found = told();
    found.is_whole = is_whole;
    return found;
  } catch (const DatabaseError& error) {
    throw rom::InputError({path_, 0}, "", std::string("cannot be read as a history in SQLite: ") + error.what());
  }
}

FoundTouchOffs TouchOffHistory::told() const {
  FoundTouchOffs found;
  for (std::size_t d = 0; d < outputs_.size(); ++d) {
    OutputTouchOffs& output = found.outputs.emplace_back(OutputTouchOffs{outputs_[d], 0, {}});
    correction::TouchOffs walk(d);
    const auto take = [&](const Row& row) {
      const double tare_m = d == 0 ? row.tare_m : 0.0;
      if (const auto reading = walk.row({row.unix_s, row.published_m[d] - tare_m, row.tares, row.orders, row.of_output,
                                         row.length_m, row.deviation_m})) {
        output.readings.push_back(*reading);
      }
    };
    for (const auto& [id, run] : runs_) {
      walk.begin_run();
      take(run.first);
      for (const Change& change : run.changes) {
        take(change.before);
        take(change.at);
      }
    }
    output.stretches = walk.stretches();
  }
  return found;
}

}  // namespace spindle_twin::firmware

#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "firmware/keep/database.hpp"

namespace spindle_twin::firmware {

/// One column of a history, thinned: of each moment the least value, the mean and the greatest; NaN: none.
struct ThinnedColumn {
  std::string name;
  std::vector<float> least, mean, greatest;
};

/// The last hours of a history in equal spans of time. A moment is the mean time of a span's rows, spans without rows
/// have none; where a run ended between two moments one without values stands between them.
struct ThinnedHours {
  double span_s = 0.0;
  bool is_whole = false;  ///< false: its oldest part is not read yet
  std::vector<double> unix_s;
  std::vector<ThinnedColumn> columns;
};

/// Reads chosen columns of the history that a SqliteHistory writes at `path`, thinned to 600 spans. The file is opened
/// for reading only and for each reading anew, each span is a transaction of its own, so a writer is never held up.
/// What cannot change any more is kept: who asks again costs the new rows. For one thread, which waits for the disk:
/// never the cycle's.
class ThinnedHistory {
 public:
  static constexpr int most_spans = 600;

  /// `columns`: names as in history_header().
  ThinnedHistory(std::string path, std::vector<std::string> columns);

  /// The `hours` (1 or more) before now_unix_s, the newest first: `go_on` is asked before each span and each 100 rows,
  /// and may rest meanwhile; when it says false what was read so far comes, and the next reading goes on from there.
  /// Throws rom::InputError naming the file: no history, of other columns or of a newer version, damaged.
  ThinnedHours read(int hours, double now_unix_s, const std::function<bool()>& go_on);

 private:
  struct Span {
    bool is_final = false;  ///< no row comes any more
    std::int64_t rows = 0;
    std::int64_t first_run = 0, last_run = 0;
    double unix_s = 0.0;
    std::vector<float> values;  ///< least, mean and greatest of each column; empty without rows
  };
  struct Kept {
    double read_unix_s = 0.0;
    std::map<std::int64_t, Span> spans;  ///< by their number since 1970
  };

  bool read_missing(Kept& kept, std::int64_t first, std::int64_t last, const std::function<bool()>& go_on,
                    double span_s) const;
  std::optional<Span> read_span(Database& database, double from_s, double to_s,
                                const std::function<bool()>& go_on) const;
  ThinnedHours told(const Kept& kept, double span_s) const;

  std::string path_;
  std::vector<std::string> columns_;
  std::string select_;
  std::map<int, Kept> kept_;  ///< by hours
};

}  // namespace spindle_twin::firmware

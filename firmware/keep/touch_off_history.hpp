#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "correction/growth/growth_reading.hpp"
#include "firmware/keep/database.hpp"

namespace spindle_twin::firmware {

/// The touch-offs of one deformation, in their order.
struct OutputTouchOffs {
  std::string output;
  std::size_t stretches = 0;  ///< between starts, gaps and tares
  std::vector<correction::GrowthReading> readings;
};

struct FoundTouchOffs {
  bool is_whole = false;  ///< false: the oldest part is not searched yet
  std::vector<OutputTouchOffs> outputs;
};

/// Finds the touch-offs in the history that a SqliteHistory writes at `path`. Within a run the numbers of tares and of
/// lengths handed over only rise, so two rows with the same numbers have none between them: a touch-off costs as many
/// rows as the run has digits in base 2, and weeks without one cost two rows a run. The file is opened for reading only
/// and for each reading anew; what was found is kept, so who asks again pays for the new rows. The newest 20,000 touch-
/// offs and tares count. For one thread, which waits for the disk: never the cycle's.
class TouchOffHistory {
 public:
  static constexpr std::size_t most_changes = 20'000;

  /// outputs: names of the network's deformations, in its order; their columns are those of history_header().
  TouchOffHistory(std::string path, std::vector<std::string> outputs);

  /// The newest runs first: `go_on` is asked each 16 rows, and may rest meanwhile; when it says false what was found so
  /// far comes, and the next reading goes on from there. Throws rom::InputError naming the file: no history, of other
  /// columns or of a newer version, damaged.
  FoundTouchOffs read(const std::function<bool()>& go_on);

 private:
  struct Row {
    std::int64_t id = 0;
    double unix_s = 0.0, tares = 0.0, orders = 0.0, of_output = 0.0, length_m = 0.0, deviation_m = 0.0, tare_m = 0.0;
    std::vector<double> published_m;  ///< by output
  };
  /// Two rows behind each other, with other numbers of tares or lengths.
  struct Change {
    Row before, at;
  };
  struct Run {
    Row first, last;  ///< searched from and to
    std::deque<Change> changes;
  };
  class Search;

  std::size_t changes() const;
  FoundTouchOffs told() const;

  std::string path_, select_;
  std::vector<std::string> outputs_;
  std::uint64_t file_ = 0;            ///< which one was read (inode)
  std::map<std::int64_t, Run> runs_;  ///< by their ids
};

}  // namespace spindle_twin::firmware

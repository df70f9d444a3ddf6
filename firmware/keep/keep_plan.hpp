#pragma once

#include <cstdint>
#include <string>

namespace spindle_twin::firmware {

/// What is written beside the history.
struct KeepPlan {
  std::string checkpoint_path;  ///< empty: none
  double interval_s = 300.0;    ///< model time
  double max_age_s = 43200.0;   ///< an older checkpoint is not used
  std::string parameters_path;  ///< empty: none
  std::string orders_path;      ///< empty: none, of tests only

  bool operator==(const KeepPlan&) const = default;
};

/// A row per cycle: in a file of text, and as many of before as there is room for, or in a database.
struct HistoryPlan {
  std::string path;                                       ///< empty: none; ending in .sqlite: a database
  std::uint64_t segment_bytes = std::uint64_t{64} << 20;  ///< of text: then a new file is begun
  std::uint64_t most_bytes = std::uint64_t{1} << 30;      ///< of all files together
  double most_days = 90.0;                                ///< of a database: older rows go

  bool operator==(const HistoryPlan&) const = default;
};

}  // namespace spindle_twin::firmware

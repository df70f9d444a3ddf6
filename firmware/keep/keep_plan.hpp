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
};

/// A file of a row per cycle, and as many of before as there is room for.
struct HistoryPlan {
  std::string path;                                       ///< empty: none
  std::uint64_t segment_bytes = std::uint64_t{64} << 20;  ///< then a new file is begun
  std::uint64_t most_bytes = std::uint64_t{1} << 30;      ///< of all files together
};

}  // namespace spindle_twin::firmware

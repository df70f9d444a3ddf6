#pragma once

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

}  // namespace spindle_twin::firmware

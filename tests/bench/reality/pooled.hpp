#pragma once

#include "tests/bench/reality/score_file.hpp"

namespace spindle_twin::bench {

/// All runs of a family together.
struct Pooled {
  int runs = 0;
  double error_um = 0.0;  ///< root mean square over the runs, as the next two
  double deviation_um = 0.0;
  double open_um = 0.0;
  double inside = 0.0;  ///< mean
  double least_inside = 1.0;
  double inside_from_1_min = 0.0;  ///< mean
  double rejected = 0.0;           ///< mean
  double worst_um = 0.0;           ///< largest of the runs, as the rest
  double failed_s = 0.0;
  double degraded_s = 0.0;
  double step_um_per_s = 0.0;
  double back_s = 0.0;
  double at_15_min_um = 0.0;
  int with_failed = 0;         ///< runs in which a healthy sensor failed
  int with_failed_at_end = 0;  ///< for more than ten minutes
  int ends_degraded = 0;
};

/// Of those seeds that `also` has as well under the name `also_family`.
Pooled pool(const Scores& scores, const std::string& family, const Scores& also, const std::string& also_family);
inline Pooled pool(const Scores& scores, const std::string& family) { return pool(scores, family, scores, family); }

}  // namespace spindle_twin::bench

#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host_tools/commands/offline/solved_field.hpp"

namespace spindle_twin::host_tools {

/// The time series of `solve`, as CSV lines on stdout while it grows or as JSON to be asked for at its end: time, key
/// points, part maxima, deformations, outlets of circuits.
class SolvedSeries {
 public:
  /// Prints the CSV's header; `file` is the description's. The model outlives the series. Throws rom::InputError where
  /// two columns would have one name.
  SolvedSeries(const std::string& file, const fem_offline::AffineModel& model, bool json);
  ~SolvedSeries();
  SolvedSeries(const SolvedSeries&) = delete;
  SolvedSeries& operator=(const SolvedSeries&) = delete;

  void add(double time_s, const SolvedField& field);

  /// Null where the series went out as CSV.
  const nlohmann::json& json() const;

 private:
  const fem_offline::AffineModel* model_;
  std::unique_ptr<nlohmann::json> series_;  ///< none: CSV
};

}  // namespace spindle_twin::host_tools

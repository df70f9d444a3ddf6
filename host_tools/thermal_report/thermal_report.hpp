#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/thermal_report/thermal_record.hpp"

namespace spindle_twin::host_tools {

/// What a compensation would have left of each measured length: reading minus prediction.
struct Compensated {
  std::string by;            ///< in words: network and law
  std::vector<Course> left;  ///< by the names of ThermalRecord::lengths; those without a prediction are missing
};

/// What a person says of the set-up: name and text.
using SetUp = std::vector<std::pair<std::string, std::string>>;

/// The numbers of a report after ISO 230-3 as JSON, which is also the data of thermal_test_page.html:
///   set_up, phases
///   etve       the standstill before the spindle turns, where it lasts at least 10 min
///   rotation   from the first turn to the last: of each length and temperature range, change and rate over the first
///              15 and 60 min and the whole, and the steepest 15 min; of lengths also of what compensation leaves
///   cooling    the standstill after it
///   time_constants   of each length and phase of at least 10 min
/// What the record does not have is null. `courses`: what is drawn.
nlohmann::ordered_json thermal_report_json(const ThermalRecord& record, const Compensated& compensated,
                                           const SetUp& set_up);

}  // namespace spindle_twin::host_tools

#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "firmware/keep/keep_plan.hpp"
#include "firmware/keep/thinned_history.hpp"
#include "firmware/show/http_answer.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// The columns of a network's history that the live page draws: growth with and without correction, the growth's
/// standard deviation, and what is measured and predicted at the key points.
std::vector<std::string> shown_columns(const rom::Network& network);

/// Thinned hours on one line, null where there is no value; lengths in um, temperatures in degC:
///   {"hours": 8, "span_s": 48, "is_whole": true, "unix_s": [...],
///    "columns": {"nose_um": {"min": [...], "mean": [...], "max": [...]}, ...}}
std::string thinned_json(int hours, const ThinnedHours& thinned);

/// Makes the page of a spindle's last hours, as SpindleToShow::history wants it; empty where the history is no
/// database. In a thread that may wait for the disk, 5 s for each page at most, and half of that it rests, so that a
/// cycle at the same priority is never held up; what is not read by then is read for the next page. Throws
/// rom::InputError.
std::function<Page(int hours, const std::atomic<bool>& stop)> history_page(const HistoryPlan& plan,
                                                                           const rom::Network& network);

}  // namespace spindle_twin::firmware

#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "firmware/keep/keep_plan.hpp"
#include "firmware/keep/touch_off_history.hpp"
#include "firmware/show/http_answer.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// Whether the compensation helps, on one line, by correction/growth; lengths in um, null where there is no value:
///   {"is_whole": true, "outputs": [{"output": "nose", "touch_offs": 13, "stretches": 2, "from_unix_s": ...,
///     "measured_times": 0.98, "whole": {"readings": 11, "growth_rms_um": ..., "growth_worst_um": ...,
///     "left_rms_um": ..., "left_worst_um": ..., "verdict": "helps"},
///     "weeks": [{"from_unix_s": ..., and what "whole" has}]}]}
std::string growth_json(const FoundTouchOffs& found);

/// Makes that page of a spindle, as SpindleToShow::growth wants it; empty where the history is no database or nothing
/// deforms. In a thread that may wait for the disk, 5 s for each page at most, and half of that it rests. Throws
/// rom::InputError.
std::function<Page(const std::atomic<bool>& stop)> growth_page(const HistoryPlan& plan, const rom::Network& network);

}  // namespace spindle_twin::firmware

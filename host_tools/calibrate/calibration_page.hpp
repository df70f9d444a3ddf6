#pragma once

#include <nlohmann/json.hpp>

#include "correction/calibrate/calibrate.hpp"

namespace spindle_twin::host_tools {

/// Data of calibration_page.html: of each channel of each test the readings that count, the model with the priors (for
/// a probe from its first reading on, as its zero is unknown) and with the fit, what is left, and 1σ of what may be
/// left; and how well each channel is met by the fit, and in its last quarter by a fit of the rest.
nlohmann::ordered_json calibration_page_data(const rom::Network& network, const correction::CalibrateOptions& options,
                                             const correction::CalibrationResult& result);

}  // namespace spindle_twin::host_tools

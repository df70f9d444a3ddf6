#pragma once

#include "tests/bench/campaign/models.hpp"
#include "tests/bench/commissioning/commission.hpp"

namespace spindle_twin::bench {

/// Machines of A whose structure the twin's FE model has wrong; each gets the test with a probe and a day of service
/// that has drifted by 5/10/5 %, with six sensors. Prints a table and limits; how many of these are missed.
int check_wrong_models(const CampaignOptions& options, const TestPlan& plan);

}  // namespace spindle_twin::bench

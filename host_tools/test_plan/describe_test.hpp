#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "correction/identify/identify.hpp"
#include "host_tools/test_plan/test_plan.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// A proposed test as `identify --test-hours --json` prints it.
nlohmann::ordered_json test_json(const rom::Network& network, const TestWish& wish, const ProposedTest& test);

/// The same for a person.
std::string test_table(const rom::Network& network, const TestWish& wish, const ProposedTest& test);

/// Data of sensors_page.html. `turning`: parts that places were not looked for on.
nlohmann::ordered_json test_page_data(const rom::Network& network, const TestWish& wish, const ProposedTest& test,
                                      const std::vector<std::string>& turning);
nlohmann::ordered_json sensors_page_data(const rom::Network& network,
                                         const std::vector<correction::SensorPlace>& sensors,
                                         const correction::Identification& found,
                                         const std::vector<std::string>& turning);

}  // namespace spindle_twin::host_tools

#pragma once

#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

#include "host_tools/inspection/inspection.hpp"

namespace spindle_twin::host_tools {

/// One thing that a network file says; `section`, `name` and `field` together are its key.
struct Fact {
  std::string section;  ///< such as "conductance"
  std::string name;     ///< such as "jacket/sleeve"; empty for the whole network
  std::string field;    ///< such as "nominal_W_per_m2K"
  std::variant<double, std::string, Eigen::MatrixXd> value;
};

/// All that the file holds, in its order, and its slowest time constants.
std::vector<Fact> network_facts(const Inspection& inspection);

}  // namespace spindle_twin::host_tools

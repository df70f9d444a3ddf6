#pragma once

#include <memory>

#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::rom::tests {

/// What steppers of a network share.
inline std::shared_ptr<const NetworkOperator> share(const Network& network) {
  return std::make_shared<const NetworkOperator>(network);
}

}  // namespace spindle_twin::rom::tests

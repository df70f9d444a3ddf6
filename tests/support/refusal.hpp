#pragma once

#include <functional>
#include <string>

#include "rom/read/input_error.hpp"

namespace spindle_twin::tests {

/// What `action` throws as InputError; empty if nothing.
inline std::string refusal_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace spindle_twin::tests

#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "rom/read/input_error.hpp"

/// Texts that readers are tried with, and what they say to them.
namespace spindle_twin::tests {

/// The text with the first `what` in it replaced. Throws std::logic_error where it holds none.
inline std::string with(std::string text, const std::string& what, const std::string& instead) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("not in the text: " + what);
  return text.replace(at, what.size(), instead);
}

/// What the call was refused with.
template <class Call>
std::string refusal_of(const Call& call) {
  try {
    call();
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace spindle_twin::tests

#pragma once

#include <optional>
#include <string>

#include "firmware/show/http_answer.hpp"

namespace spindle_twin::firmware {

/// The live page at / and its style sheet and script beside it, as they were built in from show/page; nothing at any
/// other path.
std::optional<Page> page_file(const std::string& path);

/// What the codes and bits of the registers mean, as one JSON object:
///   {"state": [{"value": 1, "name": "running", "doc": ...}, ...], "quality": ...}
std::string words_json();

}  // namespace spindle_twin::firmware

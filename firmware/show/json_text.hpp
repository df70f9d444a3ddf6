#pragma once

#include <string>
#include <string_view>

namespace spindle_twin::firmware {

/// `text` as a JSON string, with its quotes.
std::string json_text(std::string_view text);

}  // namespace spindle_twin::firmware

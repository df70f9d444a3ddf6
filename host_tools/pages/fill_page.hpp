#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace spindle_twin::host_tools {

/// A page of the generated host_tools/pages/page_texts.hpp with its data: one HTML file that opens without a network
/// and loads nothing. `data` may hold any text; strings must be UTF-8, else nlohmann::json throws.
std::string fill_page(std::string_view text, const nlohmann::ordered_json& data);

}  // namespace spindle_twin::host_tools

#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace spindle_twin::host_tools {

/// A page of the generated host_tools/pages/page_texts.hpp with its data: one HTML file that opens without a network
/// and loads nothing. `data` may hold any text; bytes that are no UTF-8 become replacement characters.
std::string fill_page(std::string_view text, const nlohmann::ordered_json& data);

}  // namespace spindle_twin::host_tools

#include "host_tools/pages/fill_page.hpp"

#include <stdexcept>

namespace spindle_twin::host_tools {

std::string fill_page(std::string_view text, const nlohmann::ordered_json& data) {
  constexpr std::string_view mark = R"(<script id="data" type="application/json">)";
  std::string json = data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  // Inside a script element no text may close it or open a comment; \u003c is the same character to JSON.
  for (std::size_t place = json.find('<'); place != std::string::npos; place = json.find('<', place + 6)) {
    json.replace(place, 1, "\\u003c");
  }
  const std::size_t place = text.find(mark);
  if (place == std::string_view::npos) throw std::logic_error("a page without a place for its data");
  std::string page(text);
  return page.insert(place + mark.size(), json);
}

}  // namespace spindle_twin::host_tools

#include <string>

#include "host_tools/network_page/page_data.hpp"
#include "host_tools/network_page/page_template.hpp"

namespace spindle_twin::host_tools {

std::string network_page(const nlohmann::ordered_json& data) {
  std::string json = data.dump();
  // Inside a script element no text may close it or open a comment; \u003c is the same character to JSON.
  for (std::size_t place = json.find('<'); place != std::string::npos; place = json.find('<', place + 6)) {
    json.replace(place, 1, "\\u003c");
  }
  std::string page = network_page_template;
  const std::string mark = "@DATA@";
  page.replace(page.find(mark), mark.size(), json);
  return page;
}

}  // namespace spindle_twin::host_tools

#include "firmware/show/page_files.hpp"

#include <spdlog/fmt/fmt.h>

#include <span>

#include "firmware/cycle/states.hpp"
#include "firmware/serve/register_map.hpp"
#include "firmware/show/json_text.hpp"
#include "firmware/show/page_texts.hpp"

namespace spindle_twin::firmware {
namespace {

std::string words_of(const char* name, std::span<const CodeName> codes) {
  std::string json;
  for (const CodeName& code : codes) {
    if (!json.empty()) json += ',';
    json +=
        fmt::format("{{\"value\":{},\"name\":{},\"doc\":{}}}", code.value, json_text(code.name), json_text(code.doc));
  }
  return fmt::format("{}:[{}]", json_text(name), json);
}

}  // namespace

std::optional<Page> page_file(const std::string& path) {
  if (path == "/") return Page{200, "text/html; charset=utf-8", std::string(live_page_html_text)};
  if (path == "/live_page.css") return Page{200, "text/css; charset=utf-8", std::string(live_page_css_text)};
  if (path == "/live_page.js") return Page{200, "text/javascript; charset=utf-8", std::string(live_page_js_text)};
  return std::nullopt;
}

std::string words_json() {
  // The compensation's block repeats codes by number only; its own are added here.
  std::string json = fmt::format("{{{},{}", words_of("compensation_rung", rung_codes),
                                 words_of("compensation_bits", compensation_bit_codes));
  for (const RegisterEntry& entry : register_entries) {
    if (!entry.codes.empty()) json.append(",").append(words_of(entry.name, entry.codes));
  }
  return json.append("}");
}

}  // namespace spindle_twin::firmware

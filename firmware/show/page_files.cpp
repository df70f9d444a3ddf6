#include "firmware/show/page_files.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "firmware/cycle/states.hpp"
#include "firmware/serve/register_map.hpp"
#include "firmware/show/json_text.hpp"
#include "firmware/show/page_texts.hpp"

namespace spindle_twin::firmware {
namespace {

struct File {
  const char* path;
  const char* type;
  std::string_view text;
};

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
  constexpr const char* html = "text/html; charset=utf-8";
  constexpr const char* css = "text/css; charset=utf-8";
  constexpr const char* script = "text/javascript; charset=utf-8";
  const std::array<File, 6> files{{{"/", html, live_page_html_text},
                                   {"/live_page.css", css, live_page_css_text},
                                   {"/live_page.js", script, live_page_js_text},
                                   {"/commissioning", html, commissioning_html_text},
                                   {"/commissioning.css", css, commissioning_css_text},
                                   {"/commissioning.js", script, commissioning_js_text}}};
  const auto found = std::find_if(files.begin(), files.end(), [&](const File& file) { return path == file.path; });
  if (found == files.end()) return std::nullopt;
  return Page{200, found->type, std::string(found->text)};
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

#include "firmware/show/state_json.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "firmware/show/json_text.hpp"
#include "firmware/show/shown_values.hpp"

namespace spindle_twin::firmware {
namespace {

bool is_float(const RegisterEntry& entry) {
  return entry.type == RegisterType::float32 || entry.type == RegisterType::float32_cdab;
}

std::string value_text(const RegisterEntry& entry, double value) {
  if (std::isnan(value)) return "null";
  if (is_float(entry)) return fmt::format("{}", static_cast<float>(value));
  const int digits = std::max(0, static_cast<int>(std::lround(std::ceil(-std::log10(entry.resolution)))));
  return fmt::format("{:.{}f}", value, digits);
}

std::string code_name(const RegisterEntry& entry, double value) {
  for (const CodeName& code : entry.codes) {
    if (code.value == value) return json_text(code.name);
  }
  return "null";
}

std::string set_bits(const RegisterEntry& entry, double value) {
  if (std::isnan(value)) return "null";
  std::string text;
  for (const CodeName& code : entry.codes) {
    if ((static_cast<unsigned>(value) & code.value) == 0) continue;
    text.append(text.empty() ? "" : ",").append(json_text(code.name));
  }
  return "[" + text + "]";
}

/// One text per slot, as an object where the slots have names, else as a list.
template <class Text>
std::string each_slot(const RegisterEntry& entry, const std::vector<std::string>* names, Text text) {
  const std::size_t count = names != nullptr ? std::min<std::size_t>(names->size(), entry.slots) : entry.slots;
  std::string all;
  for (std::size_t slot = 0; slot < count; ++slot) {
    if (slot > 0) all += ',';
    if (names != nullptr) all += json_text((*names)[slot]) + ":";
    all += text(static_cast<int>(slot));
  }
  return names != nullptr ? "{" + all + "}" : "[" + all + "]";
}

std::string register_json(const RegisterImage& image, Register which, const ShownNames& names) {
  const RegisterEntry& entry = entry_of(which);
  const bool many = entry.slots > 1;
  const std::vector<std::string>* slot_names = names.of(entry.slot_names);
  const auto put = [&](auto text) {
    const auto of_slot = [&](int slot) { return text(entry, shown_value(image, which, slot)); };
    return many ? each_slot(entry, slot_names, of_slot) : of_slot(0);
  };
  std::string json =
      fmt::format("{}:{{{}:{}", json_text(entry.name), many ? "\"values\"" : "\"value\"", put(value_text));
  if (entry.unit[0] != '\0') json += ",\"unit\":" + json_text(entry.unit);
  if (!entry.codes.empty() && entry.codes_are_bits) json += ",\"set\":" + put(set_bits);
  if (!entry.codes.empty() && !entry.codes_are_bits) json += (many ? ",\"names\":" : ",\"name\":") + put(code_name);
  return json + "}";
}

}  // namespace

std::string state_json(const RegisterImage& image, const ShownNames& names, const std::string& more) {
  std::string json = fmt::format("{{\"spindle\":{},\"version\":{},\"map_version\":{},\"registers\":{{",
                                 json_text(names.spindle), json_text(SPINDLE_TWIN_VERSION), register_map_version);
  bool first = true;
  for (std::size_t r = 0; r < register_entries.size(); ++r) {
    if (register_entries[r].command) continue;
    if (!first) json += ',';
    first = false;
    json += register_json(image, static_cast<Register>(r), names);
  }
  json += '}';
  if (!more.empty()) json.append(",").append(more);
  return json + "}";
}

}  // namespace spindle_twin::firmware

#include "firmware/show/shown_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "firmware/serve/pack.hpp"

namespace spindle_twin::firmware {

std::vector<ShownValue> shown_values(Register which, const ShownNames& names) {
  const RegisterEntry& entry = entry_of(which);
  const std::vector<std::string>* const slot_names = names.of(entry.slot_names);
  const std::size_t count =
      slot_names != nullptr ? std::min<std::size_t>(slot_names->size(), entry.slots) : entry.slots;
  std::vector<ShownValue> values;
  for (std::size_t slot = 0; slot < count; ++slot) {
    const std::string* const name = slot_names != nullptr ? &(*slot_names)[slot] : nullptr;
    const int number = static_cast<int>(slot);
    if (!entry.codes_are_bits) {
      values.push_back({which, number, name, nullptr});
      continue;
    }
    for (const CodeName& bit : entry.codes) values.push_back({which, number, name, &bit});
  }
  return values;
}

std::string shown_name(const RegisterEntry& entry) {
  std::string name = entry.name;
  constexpr std::string_view form = "_float32";
  if (name.ends_with(form)) name.resize(name.size() - form.size());
  return name;
}

bool is_shown(const RegisterEntry& entry) { return !entry.command && entry.metric != Metric::none; }

double shown_value(const RegisterImage& image, Register which, int slot) {
  if (which == Register::heartbeat) return image[entry_of(which).address];
  return get(image, which, slot);
}

double shown_value(const RegisterImage& image, const ShownValue& value) {
  const double number = shown_value(image, value.which, value.slot);
  if (value.bit == nullptr || std::isnan(number)) return number;
  return (static_cast<unsigned>(number) & value.bit->value) != 0 ? 1.0 : 0.0;
}

}  // namespace spindle_twin::firmware

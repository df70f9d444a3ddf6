#include "rom/read_laws/read_plausible.hpp"

#include <algorithm>

#include "rom/read_laws/read_speed_law.hpp"
#include "rom/units.hpp"

namespace spindle_twin::rom {
namespace {

Range read_range(const TomlTable& table, const std::string& key, Range allowed) {
  const std::vector<double> ends = table.numbers(key, 2, allowed);
  if (ends[0] > ends[1]) table.fail(key, "must be [lowest, highest] with lowest <= highest");
  return between(ends[0], ends[1]);
}

Range in_kelvin(Range range_degC) { return between(range_degC.min + zero_degC_K, range_degC.max + zero_degC_K); }

struct Word {
  const char* key;
  Range allowed;
};

constexpr Word words[] = {{"speed_rpm", any_number},
                          {"load", any_number},
                          {"film_W_per_m2K", not_negative},
                          {"contact_W_per_m2K", not_negative},
                          {"heat_W", not_negative}};

/// A table of named ranges; every name must be one of `known`.
template <typename Add>
void read_named(const TomlTable& table, const std::string& key, const std::vector<std::string>& known, Range allowed,
                const Add& add) {
  const auto names = table.optional_table(key);
  if (!names) return;
  for (const std::string& name : names->free_keys()) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      std::string choice;
      for (const std::string& one : known) choice += (choice.empty() ? "" : ", ") + one;
      names->fail(name, "there is none of this name" + (known.empty() ? "" : "; there is " + choice));
    }
    add(name, read_range(*names, name, allowed));
  }
}

}  // namespace

std::vector<PlausibleRange> read_plausible(const TomlTable& root, const std::vector<std::string>& environments,
                                           const std::vector<std::string>& circuits) {
  std::vector<PlausibleRange> ranges;
  const auto table = root.optional_table("plausible");
  if (!table) return ranges;
  for (const Word& word : words) {
    if (table->has(word.key)) ranges.push_back({word.key, read_range(*table, word.key, word.allowed)});
  }
  if (table->has("result_degC")) {
    ranges.push_back({"result_K", in_kelvin(read_range(*table, "result_degC", temperature_degC))});
  }
  read_named(*table, "temperatures_degC", environments, temperature_degC, [&](const std::string& name, Range range) {
    ranges.push_back({plausible_temperature_prefix + name, in_kelvin(range)});
  });
  read_named(*table, "flows_kg_per_s", circuits, any_number, [&](const std::string& name, Range range) {
    ranges.push_back({plausible_flow_prefix + name, range});
  });
  return ranges;
}

}  // namespace spindle_twin::rom

#include "rom/read_laws/read_physical_law.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "rom/boundary_values/held_law.hpp"
#include "rom/laws/law_fields.hpp"
#include "rom/read_laws/read_speed_law.hpp"
#include "rom/units.hpp"

namespace spindle_twin::rom {
namespace {

class ReadNumbers {
 public:
  explicit ReadNumbers(const TomlTable& table) : table_(table) {}

  void operator()(const LawField& field, double& value) const {
    if (field.written == WrittenUnit::viscosities) return;  // read_oil
    const WrittenKey key = written_key(field.name.substr(prefix_.size()), field.written);
    const Range range{key.written(field.range.min), key.written(field.range.max), field.range.min_excluded,
                      field.range.max_excluded};
    if (field.needed || table_.has(key.key)) value = key.si(table_.number(key.key, range));
  }
  void operator()(const LawField& field, bool& value) const {
    value = table_.boolean_or(std::string(field.name), value);
  }
  template <class Enum>
  requires std::is_enum_v<Enum>
  void operator()(const LawField& field, Enum& value) const {
    const std::vector<std::string> words(field.words.begin(), field.words.end());
    const std::string word = table_.choice_or(std::string(field.name), words[static_cast<std::size_t>(value)], words);
    value = static_cast<Enum>(std::find(words.begin(), words.end(), word) - words.begin());
  }
  template <class Item, class Body>
  void optional(std::string_view name, std::optional<Item>& item, const Body& body) {
    const auto inner = table_.optional_table(std::string(name));
    if (!inner) return;
    item.emplace();
    const TomlTable outer = std::exchange(table_, *inner);
    prefix_ = std::string(name) + "_";
    body(*item);
    prefix_.clear();
    table_ = outer;
  }

 private:
  TomlTable table_;
  std::string prefix_;
};

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

int place_of(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

int find_output(const TomlTable& table, const std::string& key, const std::vector<std::string>& names,
                const std::string& kind) {
  const std::string name = table.string(key);
  const int place = place_of(names, name);
  if (place < 0) table.fail(key, "there is no " + kind + " \"" + name + "\"; there are: " + listed(names));
  return place;
}

/// `name` = a part or a surrounding, `name`_degC = the nominal temperature of a part. The air of a well-mixed volume is
/// no place that a law can read: there air_degC stays as it is given.
LawTemperature read_temperature(const TomlTable& table, std::string_view word, const LawPlaces& places,
                                LawTemperature otherwise) {
  if (word.empty()) return {};
  LawTemperature temperature = otherwise;
  const std::string key(word), nominal_key = key + "_degC";
  if (table.has(key)) {
    const std::string name = table.string(key);
    temperature.part = place_of(places.parts, name);
    temperature.environment = temperature.part >= 0 ? -1 : place_of(places.environments, name);
    if (temperature.part < 0 && temperature.environment < 0) {
      table.fail(key, "there is no part or surrounding \"" + name + "\"; there are: " + listed(places.parts) + "; " +
                          listed(places.environments));
    }
  }
  if (temperature.part < 0 && temperature.environment < 0 && word != "air") {
    table.fail(key, "missing: must name a part or surrounding; there are: " + listed(places.parts) + "; " +
                        listed(places.environments));
  }
  if (temperature.environment < 0) {
    temperature.nominal_K = table.number(nominal_key, temperature_degC) + zero_degC_K;
  }
  return temperature;
}

Lubricant read_oil(const TomlTable& table) {
  const auto rows = table.rows_or_empty("viscosities", 2, between(-zero_degC_K, 1e6));
  if (rows.size() != 2 || !(rows[0][0] < rows[1][0] && rows[0][1] > rows[1][1] && rows[1][1] > 0.3)) {
    table.fail("viscosities",
               "must be two points of the oil, [[degC, mm2/s], [degC, mm2/s]], the colder and thicker one "
               "first, both above 0.3 mm2/s");
  }
  return lubricant_through(rows[0][0] + zero_degC_K, 1e-6 * rows[0][1], rows[1][0] + zero_degC_K, 1e-6 * rows[1][1]);
}

/// All numbers of a law, and what follows from those that are not there.
template <class Law>
void read_numbers(const TomlTable& table, double reference_K, Law& law) {
  if constexpr (requires { law.assembly_K; }) law.assembly_K = reference_K;
  Law::each(law, ReadNumbers(table));
  if constexpr (requires { law.oil; }) law.oil = read_oil(table);
  if constexpr (requires { law.complete([](std::string_view) { return true; }); }) {
    law.complete([&](std::string_view name) {
      bool found = false;
      Law::each(law, [&](const LawField& field, const auto&) {
        if (field.name == name) found = table.has(written_key(field.name, field.written).key);
      });
      return found;
    });
  }
}

void read_displacement(const TomlTable& table, const LawPlaces& places, BoundLaw& bound) {
  if (table.has("closing") && table.has("opening")) table.fail("opening", "cannot stand beside closing");
  for (const char* key : {"closing", "opening"}) {
    if (!table.has(key)) continue;
    bound.displacement = find_output(table, key, places.deformations, "deformation output");
    bound.displacement_sign = std::string(key) == "closing" ? 1.0 : -1.0;
    bound.nominal_displacement_m = m_per_um * table.number_or("nominal_um", 0.0);
  }
}

void read_pressure(const TomlTable& table, const LawPlaces& places, BoundLaw& bound) {
  bound.nominal_pressure_Pa = table.number("pressure_Pa", not_negative);
  if (table.has("pressure")) {
    bound.pressure = find_output(table, "pressure", places.contact_pressures, "contact pressure");
  }
}

std::vector<std::string> kinds_of(LawRole role) {
  std::vector<std::string> kinds;
  for (const LawTraits& traits : law_traits) {
    if (traits.role == role) kinds.emplace_back(traits.kind);
  }
  return kinds;
}

}  // namespace

BoundLaw read_physical_law(const PendingLaw& pending, const LawPlaces& places, double reference_K) {
  const TomlTable& table = pending.table;
  BoundLaw bound;
  const std::string kind = table.choice("kind", kinds_of(pending.role));
  bound.law.parameters = *default_law(kind);
  const std::vector<std::string> modes(law_modes.begin(), law_modes.end());
  const std::string mode = table.choice_or("mode", modes[0], modes);
  bound.law.mode = static_cast<LawMode>(std::find(modes.begin(), modes.end(), mode) - modes.begin());
  std::visit([&](auto& law) { read_numbers(table, reference_K, law); }, bound.law.parameters);

  const LawDefaults& defaults = pending.defaults;
  const LawTraits& traits = traits_of(bound.law);
  if (reads_pressure(bound.law)) {
    read_pressure(table, places, bound);
  } else {
    const LawTemperatureNames& words = traits.temperatures;
    bound.first = read_temperature(table, words.first, places, {defaults.first_part, -1, reference_K});
    bound.second =
        read_temperature(table, words.second, places, {defaults.second_part, defaults.second_environment, reference_K});
  }
  if (traits.reads_displacement) read_displacement(table, places, bound);
  bound.circuit = defaults.circuit;
  if (const std::string fault = law_fault(bound.law.parameters); !fault.empty()) table.fail("kind", fault);
  return bound;
}

double nominal_value(const TomlTable& table, const BoundLaw& law, const OperatingState& operating) {
  LawDrive drive;
  set_machine(operating, drive);
  const double value = evaluate(law.law, nominal_state(law, drive, operating.environment_K)).value;
  if (!std::isfinite(value) || value < 0.0 || (!is_heat(law.law) && value == 0.0)) {
    std::ostringstream text;
    text << "gives " << value << " at its nominal temperatures and the operating state";
    table.fail("kind", text.str());
  }
  return value;
}

bool has_law(const TomlTable& owner, const std::vector<std::string>& instead) {
  if (!owner.has("law")) return false;
  for (const std::string& key : instead) {
    if (owner.has(key)) owner.fail(key, "cannot stand beside law, which gives the value");
  }
  return true;
}

std::optional<TomlTable> optional_law(const TomlTable& owner, const std::vector<std::string>& instead) {
  if (!has_law(owner, instead)) return std::nullopt;
  return owner.table("law");
}

}  // namespace spindle_twin::rom

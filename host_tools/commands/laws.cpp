#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host_tools/commands/commands.hpp"
#include "rom/laws/law_fields.hpp"
#include "rom/range.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

/// A key as a description has it.
struct LawKey {
  std::string key, allowed, otherwise, example;
};

/// Collects the keys of a law's default; `number` is then asked of its example.
class CollectKeys {
 public:
  template <class Value>
  void operator()(const rom::LawField& field, const Value& value) {
    if (field.written == rom::WrittenUnit::viscosities) {
      if (keys_.empty() || keys_.back().key != "viscosities")
        keys_.push_back({"viscosities", "[[degC, mm2/s], [degC, mm2/s]], the colder point first", "needed", ""});
      return;
    }
    const rom::WrittenKey written = rom::written_key(field.name.substr(prefix_.size()), field.written);
    const std::string table = prefix_.empty() ? "" : prefix_.substr(0, prefix_.size() - 1) + ".";
    const double number = static_cast<double>(value);
    const std::string text = shown(field, written, number);
    LawKey key{table + written.key, range_text(field, written), "needed", there_ ? text : ""};
    if (field.name == "assembly_K") {
      key.otherwise = "the reference temperature";
    } else if (!field.needed) {
      key.otherwise = rom::is_allowed(field.range, number) ? text : "from the others";
    }
    keys_.push_back(key);
  }
  /// What may be missing is listed as if it were there: all of it is written or nothing.
  template <class Item, class Body>
  void optional(std::string_view name, const std::optional<Item>& item, const Body& body) {
    const Item listed = item.value_or(Item{});
    prefix_ = std::string(name) + "_";
    there_ = item.has_value();
    body(listed);
    there_ = true;
    prefix_.clear();
  }
  const std::vector<LawKey>& keys() const { return keys_; }

 private:
  static std::string range_text(const rom::LawField& field, const rom::WrittenKey& written) {
    if (field.words.data() == rom::off_on.data()) return "true or false";
    std::string words;
    for (const std::string_view word : field.words) words.append(words.empty() ? "" : ", ").append(word);
    if (!words.empty()) return words;
    return rom::allowed({written.written(field.range.min), written.written(field.range.max), field.range.min_excluded,
                         field.range.max_excluded});
  }
  static std::string shown(const rom::LawField& field, const rom::WrittenKey& written, double number) {
    if (field.words.data() == rom::off_on.data()) return number != 0.0 ? "true" : "false";
    if (!field.words.empty()) return std::string(field.words[static_cast<std::size_t>(number)]);
    return rom::printed(written.written(number));
  }

  std::string prefix_;
  bool there_ = true;  ///< what is listed has numbers of its own
  std::vector<LawKey> keys_;
};

std::vector<LawKey> keys_of(const rom::LawParameters& law) {
  CollectKeys collect;
  std::visit([&]<class Law>(const Law& parameters) { Law::each(parameters, collect); }, law);
  return collect.keys();
}

std::string role_of(rom::LawRole role) {
  switch (role) {
    case rom::LawRole::heat:
      return "heat";
    case rom::LawRole::conductance:
      return "contact or film";
    case rom::LawRole::channel:
      break;
  }
  return "coolant circuit";
}

std::string reads(const rom::LawTraits& traits) {
  std::string text(traits.temperatures.first);
  const auto add = [&](std::string_view word) { text.append(text.empty() || word.empty() ? "" : ", ").append(word); };
  add(traits.temperatures.second);
  if (traits.measured == rom::MeasuredDrive::current) add("the measured current");
  if (traits.measured == rom::MeasuredDrive::power) add("the measured power");
  if (traits.reads_displacement) add("closing or opening (a deformation output)");
  return text;
}

void print_list() {
  std::printf("%-20s %-16s %s\n", "kind", "of", "reads");
  for (const rom::LawTraits& traits : rom::law_traits) {
    std::printf("%-20s %-16s %s\n", std::string(traits.kind).c_str(), role_of(traits.role).c_str(),
                reads(traits).c_str());
  }
}

void print_keys(const std::string& kind) {
  const auto law = rom::default_law(kind);
  if (!law) {
    std::string kinds;
    for (const rom::LawTraits& traits : rom::law_traits) kinds.append(kinds.empty() ? "" : ", ").append(traits.kind);
    throw rom::InputError({}, "kind", "there is no law \"" + kind + "\"; there are: " + kinds);
  }
  const std::vector<LawKey> keys = keys_of(*law), examples = keys_of(*rom::example_law(kind));
  std::printf("%-36s %-26s %-12s %s\n", "key", "default", "example", "allowed");
  for (std::size_t i = 0; i < keys.size(); ++i) {
    std::printf("%-36s %-26s %-12s %s\n", keys[i].key.c_str(), keys[i].otherwise.c_str(), examples[i].example.c_str(),
                keys[i].allowed.c_str());
  }
}

}  // namespace

void add_laws(CLI::App& app) {
  CLI::App* command = app.add_subcommand("laws", "List the physical laws of descriptions, or the keys of one");
  const auto kind = std::make_shared<std::string>();
  command->add_option("kind", *kind, "word of a law; left out: all laws and what they read");
  command->callback([kind] { kind->empty() ? print_list() : print_keys(*kind); });
}

}  // namespace spindle_twin::host_tools

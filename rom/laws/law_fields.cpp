#include "rom/laws/law_fields.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace spindle_twin::rom {
namespace {

template <class Value>
double number_of(const Value& value) {
  return static_cast<double>(value);
}

template <class Value>
void put(double number, Value& value) {
  if constexpr (std::is_same_v<Value, bool>) {
    value = number != 0.0;
  } else {
    value = static_cast<Value>(number);
  }
}

std::string printed(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Empty if `number` may stand in `field`.
std::string fault_of(const LawField& field, double number) {
  const Range& range = field.range;
  const bool low = range.min_excluded ? number > range.min : number >= range.min;
  const bool high = range.max_excluded ? number < range.max : number <= range.max;
  if (std::isfinite(number) && low && high && (field.words.empty() || number == std::floor(number))) return {};
  if (!field.words.empty()) return std::string(field.name) + ": must be a whole number up to " + printed(range.max);
  return std::string(field.name) + ": must be a number from " + printed(range.min) +
         (range.min_excluded ? " (excluded)" : "") + " to " + printed(range.max) +
         (range.max_excluded ? " (excluded)" : "");
}

struct Collect {
  std::vector<NamedNumber> numbers;

  template <class Value>
  void operator()(const LawField& field, const Value& value) {
    numbers.push_back({std::string(field.name), number_of(value)});
  }
  template <class Item, class Body>
  void optional(std::string_view, const std::optional<Item>& item, const Body& body) {
    if (item) body(*item);
  }
};

struct FindFault {
  std::string fault;

  template <class Value>
  void operator()(const LawField& field, const Value& value) {
    if (fault.empty()) fault = fault_of(field, number_of(value));
  }
  template <class Item, class Body>
  void optional(std::string_view, const std::optional<Item>& item, const Body& body) {
    if (item) body(*item);
  }
};

struct Assign {
  const std::vector<NamedNumber>& numbers;
  std::size_t used = 0;

  const NamedNumber* find(std::string_view name) const {
    const auto found = std::find_if(numbers.begin(), numbers.end(), [&](const auto& one) { return one.name == name; });
    return found == numbers.end() ? nullptr : &*found;
  }
  template <class Value>
  void operator()(const LawField& field, Value& value) {
    const NamedNumber* given = find(field.name);
    if (given == nullptr) {
      if (field.needed) throw std::invalid_argument(std::string(field.name) + ": missing");
      return;
    }
    if (const std::string fault = fault_of(field, given->value); !fault.empty()) throw std::invalid_argument(fault);
    ++used;
    put(given->value, value);
  }
  /// What may be missing is there if one of its numbers is: they begin with its name.
  template <class Item, class Body>
  void optional(std::string_view name, std::optional<Item>& item, const Body& body) {
    const std::string prefix = std::string(name) + "_";
    const bool there = std::any_of(numbers.begin(), numbers.end(),
                                   [&](const NamedNumber& one) { return one.name.starts_with(prefix); });
    if (!there) return;
    item.emplace();
    body(*item);
  }
};

template <std::size_t... I>
std::optional<LawParameters> make_kind(std::string_view kind, std::index_sequence<I...>) {
  std::optional<LawParameters> made;
  ((kind == law_kinds[I] ? (void)made.emplace(std::in_place_index<I>) : void()), ...);
  return made;
}

}  // namespace

std::optional<LawParameters> default_law(std::string_view kind) {
  return make_kind(kind, std::make_index_sequence<std::variant_size_v<LawParameters>>());
}

std::vector<NamedNumber> law_numbers(const LawParameters& parameters) {
  Collect collect;
  std::visit([&](const auto& law) { law_fields::each(law, collect); }, parameters);
  return std::move(collect.numbers);
}

LawParameters law_from_numbers(const std::string& kind, const std::vector<NamedNumber>& numbers) {
  std::optional<LawParameters> made = default_law(kind);
  if (!made) throw std::invalid_argument("there is no law \"" + kind + "\"");
  Assign assign{numbers};
  std::visit([&](auto& law) { law_fields::each(law, assign); }, *made);
  if (assign.used != numbers.size())
    throw std::invalid_argument(kind + ": has a number that it does not know, or twice");
  return *made;
}

std::string law_fault(const LawParameters& parameters) {
  FindFault find;
  std::visit([&](const auto& law) { law_fields::each(law, find); }, parameters);
  if (!find.fault.empty()) return find.fault;
  if (const auto* contact = std::get_if<ContactLaw>(&parameters); contact != nullptr && contact->fit) {
    const InterferenceFit& fit = *contact->fit;
    if (!(fit.bore_radius_m < fit.joint_radius_m && fit.joint_radius_m < fit.outer_radius_m)) {
      return "fit_joint_radius_m: must lie between bore and outer radius";
    }
  }
  if (const auto* channel = std::get_if<ChannelLaw>(&parameters);
      channel != nullptr && !(channel->liquid.coldest_K + 2.0 < channel->liquid.hottest_K &&
                              channel->liquid.vogel_zero_K < channel->liquid.coldest_K)) {
    return "liquid_coldest_K: must lie above vogel_zero_K and 2 K below hottest_K";
  }
  return {};
}

bool is_channel(const PhysicalLaw& law) { return std::holds_alternative<ChannelLaw>(law.parameters); }

}  // namespace spindle_twin::rom

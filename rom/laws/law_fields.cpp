#include "rom/laws/law_fields.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "rom/units.hpp"

namespace spindle_twin::rom {
namespace {

template <class Value>
double as_double(const Value& value) {
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

/// Empty if `number` may stand in `field`.
std::string fault_of(const LawField& field, double number) {
  const bool whole = field.words.empty() || number == std::floor(number);
  if (whole && is_allowed(field.range, number)) return {};
  const std::string what =
      field.words.empty() ? allowed(field.range) : "a whole number up to " + printed(field.range.max);
  return std::string(field.name) + ": must be " + what;
}

struct Collect {
  std::vector<NamedNumber> numbers;

  template <class Value>
  void operator()(const LawField& field, const Value& value) {
    numbers.push_back({std::string(field.name), as_double(value)});
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
    if (fault.empty()) fault = fault_of(field, as_double(value));
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

/// What make() gives for the law whose kind it is.
template <class Make, class... Laws>
std::optional<LawParameters> law_of(std::string_view kind, const Make& make, const std::variant<Laws...>*) {
  std::optional<LawParameters> made;
  ((kind == Laws::traits.kind ? (void)made.emplace(make(std::type_identity<Laws>())) : void()), ...);
  return made;
}

constexpr const LawParameters* every_law = nullptr;

}  // namespace

WrittenKey written_key(std::string_view name, WrittenUnit unit) {
  const auto instead = [&](std::string_view si_unit, std::string_view by) {
    return std::string(name.substr(0, name.size() - si_unit.size())).append(by);
  };
  switch (unit) {
    case WrittenUnit::mm:
      return {instead("_m", "_mm"), 1e-3, 0.0};
    case WrittenUnit::um:
      return {instead("_m", "_um"), 1e-6, 0.0};
    case WrittenUnit::mm2:
      return {instead("_m2", "_mm2"), 1e-6, 0.0};
    case WrittenUnit::degree:
      return {instead("_rad", "_deg"), std::numbers::pi / 180.0, 0.0};
    case WrittenUnit::degC:
      return {instead("_K", "_degC"), 1.0, zero_degC_K};
    case WrittenUnit::viscosities:
      return {"viscosities"};
    case WrittenUnit::si:
      break;
  }
  return {std::string(name)};
}

std::optional<LawParameters> default_law(std::string_view kind) {
  return law_of(
      kind, []<class Law>(std::type_identity<Law>) { return Law{}; }, every_law);
}

std::optional<LawParameters> example_law(std::string_view kind) {
  return law_of(
      kind, []<class Law>(std::type_identity<Law>) { return Law::example(); }, every_law);
}

std::vector<NamedNumber> law_numbers(const LawParameters& parameters) {
  Collect collect;
  std::visit([&]<class Law>(const Law& law) { Law::each(law, collect); }, parameters);
  return std::move(collect.numbers);
}

LawParameters law_from_numbers(const std::string& kind, const std::vector<NamedNumber>& numbers) {
  std::optional<LawParameters> made = default_law(kind);
  if (!made) throw std::invalid_argument("there is no law \"" + kind + "\"");
  Assign assign{numbers};
  std::visit([&]<class Law>(Law& law) { Law::each(law, assign); }, *made);
  if (assign.used != numbers.size())
    throw std::invalid_argument(kind + ": has a number that it does not know, or twice");
  return *made;
}

std::string law_fault(const LawParameters& parameters) {
  return std::visit(
      []<class Law>(const Law& law) {
        FindFault find;
        Law::each(law, find);
        if constexpr (requires { law.fault(); }) {
          if (find.fault.empty()) find.fault = law.fault();
        }
        return find.fault;
      },
      parameters);
}

}  // namespace spindle_twin::rom

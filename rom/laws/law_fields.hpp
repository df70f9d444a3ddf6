#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "rom/laws/evaluate.hpp"

/// Every law's numbers as a list, from which descriptions are read, files written and checked, and networks shown and
/// compared. Not for the cycle.
namespace spindle_twin::rom {

inline constexpr std::array<std::string_view, 3> law_modes = {"standard", "as_published", "as_printed"};

/// Traits of LawParameters' alternatives, in their order.
inline constexpr auto law_traits = []<class... Laws>(std::type_identity<std::variant<Laws...>>) {
  return std::array<LawTraits, sizeof...(Laws)>{Laws::traits...};
}(std::type_identity<LawParameters>());

/// Name and value of one number of a law, SI.
struct NamedNumber {
  std::string name;
  double value = 0.0;
};

/// A number's key as a person writes it: written = (SI − shift) / scale.
struct WrittenKey {
  std::string key;
  double scale = 1.0;
  double shift = 0.0;

  double si(double as_written) const { return scale * as_written + shift; }
  double written(double in_si) const { return (in_si - shift) / scale; }
};
/// Of a number whose name, without the table that it stands in, is `name`.
WrittenKey written_key(std::string_view name, WrittenUnit unit);

/// The law of a kind with its default numbers; nothing for an unknown kind.
std::optional<LawParameters> default_law(std::string_view kind);
/// The law of a kind with numbers in the middle of its range; nothing for an unknown kind.
std::optional<LawParameters> example_law(std::string_view kind);

/// All numbers of a law in the order of its `each`; a fit that is missing has none.
std::vector<NamedNumber> law_numbers(const LawParameters& parameters);

/// The law of `kind` (one of law_traits) from its numbers. Throws std::invalid_argument, saying what is wrong, for an
/// unknown kind or name, a number that is missing, given twice or outside its range.
LawParameters law_from_numbers(const std::string& kind, const std::vector<NamedNumber>& numbers);

/// Empty, or what is wrong with the law's numbers: a name and what is allowed.
std::string law_fault(const LawParameters& parameters);

}  // namespace spindle_twin::rom

#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "rom/laws/smooth.hpp"
#include "rom/range.hpp"

/// What a law says of itself. A law of the network is one struct at the end of the header of its physics, named once in
/// rom/laws/law_list.hpp; descriptions, files, checks, displays, integrators and tests go by what stands in it:
///
///   static constexpr LawTraits traits          its word, whether it is a heat or a conductance, what it reads
///   members with their defaults                its numbers, SI
///   static void each(law, visit)               visit(LawField, number) for each of them
///   LawValue<Number> value(inputs) const       the law itself, for any scalar of smooth.hpp; cycle-safe
///   static Law example()                       numbers in the middle of its range: tests begin there, `laws` shows
///   them
///
/// and where the law needs them:
///
///   std::string_view fault() const             what is wrong between its numbers; empty: nothing
///   bool reads_pressure() const                a contact pressure stands in place of both temperatures
///   void complete(given)                       defaults that follow from other numbers; given(name): it was written
///   double assembly_K                          by default the temperature at which the description was assembled
///   Lubricant oil                              written as two points, `viscosities`
namespace spindle_twin::rom {

/// What a law may depend on and an integrator differentiates by. `first` and `second` are the mean temperatures of two
/// parts, or of a part and what it gives its heat to; each law says which.
enum class LawInput : std::size_t { first_K, second_K, pressure_Pa, displacement_m, speed_rpm, flow_kg_per_s };
constexpr std::size_t law_inputs = 6;

/// One instant, as a law sees it.
struct LawState {
  std::array<double, law_inputs> inputs{};
  double load = 0.0;                ///< fraction of the rated load
  std::optional<double> current_A;  ///< measured phase current, rms; otherwise rated current times load
  std::optional<double> power_W;    ///< measured electrical power; otherwise rated power times load

  double& operator[](LawInput input) { return inputs[static_cast<std::size_t>(input)]; }
  double operator[](LawInput input) const { return inputs[static_cast<std::size_t>(input)]; }
};

/// The same as the law's scalar, so that it may know the slopes.
template <class Number>
struct LawInputs {
  LawMode mode;
  const LawState& state;
  Number first_K, second_K, pressure_Pa, displacement_m, speed_rpm, flow_kg_per_s;

  Number mean_K() const { return 0.5 * (first_K + second_K); }
};

/// Whose value a law is: a heat [W], a conductance [W/m²K], or that of a coolant circuit's segments.
enum class LawRole { heat, conductance, channel };

/// What a law reads as first and second temperature, as a person names it; empty: nothing.
struct LawTemperatureNames {
  std::string_view first;
  std::string_view second;
};

/// What a heat takes from the machine in place of the load, where it is measured.
enum class MeasuredDrive { none, current, power };

struct LawTraits {
  std::string_view kind;  ///< its word in descriptions and files
  LawRole role = LawRole::heat;
  LawTemperatureNames temperatures = {};
  MeasuredDrive measured = MeasuredDrive::none;
  bool reads_displacement = false;  ///< a deformation output: + = two rings come nearer
};

/// How a person writes a number that is not written in the SI unit of its name: in another unit, or, of a lubricant's
/// two, as two points of the oil.
enum class WrittenUnit { si, mm, um, mm2, degree, degC, viscosities };

/// One number of a law. `name` ends in its SI unit; what a person writes ends in that of `written`.
struct LawField {
  std::string_view name;
  Range range;         ///< SI
  bool needed = true;  ///< otherwise a description may leave it at its default
  WrittenUnit written = WrittenUnit::si;
  std::span<const std::string_view> words;  ///< of a choice, whose number is the index; else empty
};

inline constexpr std::array<std::string_view, 2> off_on = {"off", "on"};

/// Ranges that laws share.
namespace law_ranges {

inline constexpr Range any{-1e15, 1e15, false, false};
inline constexpr Range length_m{0.0, 1e3, true, false};
inline constexpr Range above_0{0.0, 1e15, true, false};
inline constexpr Range from_0{0.0, 1e15, false, false};
inline constexpr Range kelvin{0.0, 1e4, true, false};
inline constexpr Range angle_rad{0.0, 1.5707, true, true};
inline constexpr Range expansion{0.0, 1e-2, false, false};

}  // namespace law_ranges

/// What every law of the list must have.
template <class Law>
concept IsLaw = requires(const Law& law, const LawInputs<double>& in) {
  { Law::traits } -> std::convertible_to<LawTraits>;
  { Law::example() } -> std::same_as<Law>;
  { law.value(in) } -> std::same_as<LawValue<double>>;
};

}  // namespace spindle_twin::rom

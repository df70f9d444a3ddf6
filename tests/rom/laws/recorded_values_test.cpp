#include <gtest/gtest.h>

#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "rom/laws/evaluate.hpp"
#include "rom/laws/law_fields.hpp"
#include "rom/range.hpp"
#include "tests/support/recorded.hpp"

/// Every law over a grid of states, in each mode, says what it said when this was recorded, and reads what it read.
namespace spindle_twin::rom::test {
namespace laws_recorded_values_test {

constexpr spindle_twin::tests::Tolerance tolerance{1e-9};

struct Law {
  std::string name;
  LawParameters parameters;
};

std::vector<Law> laws() {
  std::vector<Law> all;
  for (const LawTraits& traits : law_traits) all.push_back({std::string(traits.kind), *example_law(traits.kind)});
  ContactLaw fitted = ContactLaw::example();
  fitted.fit = InterferenceFit{0.037, 0.04, 0.05, 219e9, 0.3, 1.2e-5, 209e9, 0.269, 1.17e-5, 4e-6, 1e-12};
  all.push_back({"contact_of_a_fit", fitted});
  return all;
}

LawState state_at(double first_K, double second_K, double speed_rpm, double share) {
  LawState state;
  state[LawInput::first_K] = first_K;
  state[LawInput::second_K] = second_K;
  state[LawInput::speed_rpm] = speed_rpm;
  state[LawInput::pressure_Pa] = 2e6 * share;
  state[LawInput::displacement_m] = 3e-6 * (share - 0.5);
  state[LawInput::flow_kg_per_s] = 0.2 * (share - 0.3);
  state.load = share;
  if (share > 0.9) {
    state.current_A = 12.0;
    state.power_W = 2500.0;
  }
  return state;
}

std::string line_of(const Law& law, LawMode mode, const LawState& state) {
  const LawEvaluation found = evaluate({mode, law.parameters}, state);
  char text[64];
  std::snprintf(text, sizeof text, " mode %d speed %g load %g: ", static_cast<int>(mode), state[LawInput::speed_rpm],
                state.load);
  std::string line = law.name + text;
  const auto add = [&](double value) {
    std::snprintf(text, sizeof text, " %.12g", value == 0.0 ? 0.0 : value);
    line += text;
  };
  add(found.value);
  for (const double slope : found.slope) add(slope);
  return line + " flags " + std::to_string(found.flags) + "\n";
}

TEST(RecordedLaws, give_the_values_slopes_and_flags_that_they_gave) {
  std::string now;
  for (const Law& law : laws()) {
    for (const LawMode mode : {LawMode::standard, LawMode::as_published, LawMode::as_printed}) {
      for (const double speed_rpm : {-9000.0, 0.3, 300.0, 4000.0, 16000.0}) {
        for (const double share : {0.05, 0.35, 1.0}) {
          const LawState state = state_at(305.0 + 40.0 * share, 300.0 + 9.0 * share, speed_rpm, share);
          now += line_of(law, mode, state);
        }
      }
    }
  }
  spindle_twin::tests::expect_as_recorded("laws.txt", now, tolerance);
}

/// A line for each number that a law reads: what it may be, in SI, and what it is where nobody says.
class ListKeys {
 public:
  explicit ListKeys(std::string_view kind) : kind_(kind) {}

  template <class Value>
  void operator()(const LawField& field, const Value& value) {
    const WrittenKey key = written_key(field.name, field.written);
    char text[96];
    std::snprintf(text, sizeof text, ", %s, %.12g, written ", field.needed ? "needed" : "or",
                  static_cast<double>(value));
    lines_ += kind_ + " " + std::string(field.name) + ": " + allowed(field.range) + text + key.key;
    std::snprintf(text, sizeof text, " %.12g", key.si(1.0));
    lines_ += text;
    for (const std::string_view word : field.words) lines_ += " " + std::string(word);
    lines_ += "\n";
  }
  template <class Item, class Body>
  void optional(std::string_view name, const std::optional<Item>& /*given*/, const Body& body) {
    lines_ += kind_ + " " + std::string(name) + " or all of:\n";
    const Item item;
    body(item);
  }
  const std::string& lines() const { return lines_; }

 private:
  std::string kind_, lines_;
};

TEST(RecordedLaws, read_the_numbers_within_the_limits_and_with_the_defaults_that_they_had) {
  std::string now;
  for (const LawTraits& traits : law_traits) {
    ListKeys list(traits.kind);
    std::visit([&]<class Law>(const Law& law) { Law::each(law, list); }, *default_law(traits.kind));
    now += list.lines();
  }
  spindle_twin::tests::expect_as_recorded("law_keys.txt", now, tolerance);
}

}  // namespace laws_recorded_values_test
}  // namespace spindle_twin::rom::test

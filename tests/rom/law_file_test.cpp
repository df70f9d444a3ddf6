#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/laws/law_fields.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::rom::tests {
namespace law_file_test {

using spindle_twin::tests::refusal_of;

TEST(LawFile, every_law_survives_the_file_bit_for_bit) {
  const Network network = make_network_with_laws();
  const std::vector<std::uint8_t> bytes = encode_network(network);
  const RomFile file = decode_rom_file(bytes, "laws.rom");
  EXPECT_EQ(file.schema_version, 6u);
  EXPECT_EQ(encode_network(file.network), bytes);
  const auto same = [](const std::optional<BoundLaw>& a, const std::optional<BoundLaw>& b, const std::string& name) {
    ASSERT_EQ(a.has_value(), b.has_value()) << name;
    if (!a) return;
    ASSERT_EQ(a->law.parameters.index(), b->law.parameters.index()) << name;
    EXPECT_EQ(a->law.mode, b->law.mode) << name;
    const auto numbers = law_numbers(a->law.parameters), read = law_numbers(b->law.parameters);
    ASSERT_EQ(numbers.size(), read.size()) << name;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      EXPECT_EQ(numbers[i].name, read[i].name) << name;
      EXPECT_EQ(numbers[i].value, read[i].value) << name << " " << numbers[i].name;
    }
    for (const auto& [mine, its] : {std::pair{a->first, b->first}, {a->second, b->second}}) {
      EXPECT_EQ(mine.part, its.part) << name;
      EXPECT_EQ(mine.environment, its.environment) << name;
      EXPECT_EQ(mine.nominal_K, its.nominal_K) << name;
    }
    EXPECT_EQ(a->pressure, b->pressure) << name;
    EXPECT_EQ(a->displacement, b->displacement) << name;
    EXPECT_EQ(a->displacement_sign, b->displacement_sign) << name;
    EXPECT_EQ(a->nominal_pressure_Pa, b->nominal_pressure_Pa) << name;
    EXPECT_EQ(a->circuit, b->circuit) << name;
  };
  for (std::size_t i = 0; i < network.boundaries.sources.size(); ++i) {
    same(network.boundaries.sources[i].physics, file.network.boundaries.sources[i].physics,
         network.boundaries.sources[i].name);
  }
  for (std::size_t j = 0; j < network.boundaries.conductances.size(); ++j) {
    same(network.boundaries.conductances[j].physics, file.network.boundaries.conductances[j].physics,
         network.boundaries.conductances[j].name);
  }
}

/// Every number of every law, moved out of its range, is refused by name.
TEST(LawFile, every_number_out_of_range_is_refused_by_name) {
  const Network network = make_network_with_laws();
  int numbers = 0;
  const auto expect_refused = [&](const std::optional<BoundLaw>& law) {
    if (!law) return;
    const std::string kind(traits_of(law->law).kind);
    const std::vector<NamedNumber> right = law_numbers(law->law.parameters);
    for (std::size_t i = 0; i < right.size(); ++i) {
      for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), -1e20, 1e20}) {
        std::vector<NamedNumber> bad = right;
        bad[i].value = wrong;
        try {
          law_from_numbers(kind, bad);
          ADD_FAILURE() << kind << " " << right[i].name << " = " << wrong << " was taken";
        } catch (const std::invalid_argument& error) {
          EXPECT_NE(std::string(error.what()).find(right[i].name), std::string::npos) << error.what();
        }
      }
      ++numbers;
    }
    std::vector<NamedNumber> doubled = right;
    doubled.push_back(right[0]);
    EXPECT_THROW(law_from_numbers(kind, doubled), std::invalid_argument);
    doubled.back().name = "unheard_of";
    EXPECT_THROW(law_from_numbers(kind, doubled), std::invalid_argument);
    EXPECT_THROW(law_from_numbers("cold_fusion", right), std::invalid_argument);
    EXPECT_THROW(law_from_numbers(kind, {}), std::invalid_argument);
  };
  for (const HeatSource& source : network.boundaries.sources) expect_refused(source.physics);
  for (const Conductance& conductance : network.boundaries.conductances) expect_refused(conductance.physics);
  EXPECT_GT(numbers, 150);
}

TEST(LawFile, laws_in_the_wrong_place_are_refused_with_file_and_field) {
  struct Case {
    const char* what;
    std::function<void(Network&)> spoil;
    const char* says;
  };
  const auto source = [](Network& network) -> BoundLaw& { return *network.boundaries.sources[2].physics; };
  const std::vector<Case> cases = {
      {"part", [&](Network& n) { source(n).first.part = 4; }, "source front bearing law part: names one that does not"},
      {"environment",
       [&](Network& n) {
         source(n).second = {-1, 2};
       },
       "law environment: names one"},
      {"both", [&](Network& n) { source(n).first.environment = 0; }, "a part's or an environment's"},
      {"kelvin", [&](Network& n) { source(n).first.nominal_K = -3.0; }, "above 0 K"},
      {"output", [&](Network& n) { source(n).displacement = 2; }, "law displacement: names one"},
      {"circuit", [&](Network& n) { source(n).circuit = 0; }, "law circuit: must be the circuit"},
      {"mode", [&](Network& n) { source(n).law.mode = static_cast<LawMode>(law_modes.size()); },
       "law mode: does not exist"},
      {"sign", [&](Network& n) { source(n).displacement_sign = std::nan(""); }, "not finite"},
      {"range", [&](Network& n) { std::get<BearingHeatLaw>(source(n).law.parameters).friction.pitch_diameter_m = 0.0; },
       "pitch_diameter_m: must be a number from 0 (excluded)"},
      {"kind", [&](Network& n) { n.boundaries.sources[0].physics = n.boundaries.conductances[0].physics; },
       "source bearing law: is one of a conductance"},
      {"heat", [&](Network& n) { n.boundaries.conductances[0].physics = source(n); }, "law: is one of a heat"},
      {"channel", [&](Network& n) { n.boundaries.conductances[0].physics = n.boundaries.conductances[6].physics; },
       "of a channel belongs to the segments"},
      {"fit",
       [&](Network& n) {
         std::get<ContactLaw>(n.boundaries.conductances[0].physics->law.parameters).fit->bore_radius_m = 0.05;
       },
       "must lie between bore and outer radius"}};
  for (const Case& item : cases) {
    Network network = make_network_with_laws();
    item.spoil(network);
    const std::string said = refusal_of([&] { check_network(network, "laws.rom"); });
    EXPECT_NE(said.find("laws.rom: "), std::string::npos) << item.what;
    EXPECT_NE(said.find(item.says), std::string::npos) << item.what << ": " << said;
  }
}

}  // namespace law_file_test
}  // namespace spindle_twin::rom::tests

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "fem_offline/exchange_files/calculix_deck.hpp"
#include "fem_offline/exchange_files/freefem_deck.hpp"
#include "tests/fem_offline/exchange_files/spindle_decks.hpp"

namespace spindle_twin::fem_offline {
namespace exchange_files_fluids_test {

using namespace exchange_files_test;

class DeckFluids : public testing::Test {
 protected:
  DeckFluids() : folder(std::filesystem::temp_directory_path() / ("fluids_test_" + std::to_string(getpid()))) {
    plan.surrounding_K = spindle.operating.surrounding_K;
  }
  ~DeckFluids() override { std::filesystem::remove_all(folder); }

  /// Temperatures of the *FILM lines on the sides that the fluid wets.
  std::set<double> sinks(const DeckModel& deck, const std::string& file, std::size_t fluid) const {
    std::set<std::string> faces;
    for (const DeckFilm& film : deck.films) {
      if (film.fluid != fluid) continue;
      for (const DeckSide& side : deck.sides_of_piece[film.piece]) {
        faces.insert(std::to_string(side.element + 1) + ", F" + std::to_string(side.side + 1));
      }
    }
    std::set<double> found;
    std::istringstream lines(text_of(folder / file));
    for (std::string line; std::getline(lines, line);) {
      const std::size_t comma = line.find(", ", line.find(", ") + 1);
      if (comma != std::string::npos && faces.contains(line.substr(0, comma))) {
        found.insert(std::stod(line.substr(comma + 2)));
      }
    }
    return found;
  }

  Spindle spindle = read_spindle(spindles + "jacket_circuit.toml");
  DeckPlan plan;
  std::filesystem::path folder;
};

TEST_F(DeckFluids, a_coolant_circuit_goes_over_as_films_at_the_liquids_temperature) {
  const DeckModel deck = make_deck_model(spindle, values_of(spindle));
  ASSERT_EQ(deck.fluids.size(), 6u);
  write_calculix_deck(spindle, deck, plan, still_fluids(deck), folder);
  const std::string transient = text_of(folder / "transient_loads.inc");
  const std::string amplitudes = text_of(folder / "transient.inp");
  const auto outputs = nlohmann::json::parse(text_of(folder / "outputs.json"))["fluids"];
  for (std::size_t f = 0; f < 6; ++f) {
    const std::string name = "groove_" + std::to_string(f + 1), set = "V" + std::to_string(f);
    EXPECT_EQ(deck.fluids[f].name, name);
    EXPECT_EQ(deck.fluids[f].upstream, f == 0 ? std::optional<std::size_t>() : f - 1);
    const std::set<double> steady = sinks(deck, "steady_loads.inc", f);
    ASSERT_EQ(steady.size(), 1u) << name;
    EXPECT_NEAR(*steady.begin(), 300.0 + static_cast<double>(f) - 273.15, 1e-9);
    EXPECT_NE(transient.find("*FILM, AMPLITUDE=" + set + "\n"), std::string::npos);
    EXPECT_NE(amplitudes.find("*AMPLITUDE, NAME=" + set + ","), std::string::npos);
    EXPECT_EQ(outputs[name]["circuit"], "helix");
    EXPECT_EQ(outputs[name]["flow_W_per_K"], 100.0);
    EXPECT_EQ(outputs[name].value("upstream", ""), f == 0 ? "" : "groove_" + std::to_string(f));
  }
}

/// FreeFEM solves for the liquid: 100 W/K times its rise over a segment is what the walls give it there.
TEST_F(DeckFluids, freefem_passes_the_liquid_from_segment_to_segment) {
  const DeckModel deck = make_deck_model(spindle, values_of(spindle));
  write_freefem_deck(spindle, deck, plan, folder);
  const std::string script = text_of(folder / "spindle.edp");
  EXPECT_NE(script.find("Q(first(2)) = 20.0000000000;"), std::string::npos);
  EXPECT_NE(script.find("real own0 = 1.00000000000;"), std::string::npos);
  for (std::size_t f = 1; f < 6; ++f) {
    const std::string here = std::to_string(f), before = std::to_string(f - 1);
    EXPECT_NE(script.find("real own" + here + " = 100.000000000;"), std::string::npos) << f;
    EXPECT_NE(script.find("real up" + here + " = wet" + before + " - own" + here + ";"), std::string::npos) << f;
  }
}

TEST_F(DeckFluids, a_circuit_that_runs_backwards_begins_at_its_last_segment) {
  spindle.circuits[0].flow_kg_per_s = -0.02;
  const DeckModel deck = make_deck_model(spindle, values_of(spindle));
  for (std::size_t f = 0; f < 6; ++f) {
    EXPECT_EQ(deck.fluids[f].upstream, f == 5 ? std::optional<std::size_t>() : f + 1) << f;
    EXPECT_EQ(deck.fluids[f].flow_W_per_K, 100.0);
  }
}

TEST_F(DeckFluids, liquid_that_stands_still_stays_at_the_inlets_temperature) {
  rom::BoundaryValues values = values_of(spindle);
  values.coolant_W_per_K[0] = 0.0;
  const DeckModel deck = make_deck_model(spindle, values);
  write_freefem_deck(spindle, deck, plan, folder);
  const std::string script = text_of(folder / "spindle.edp");
  for (std::size_t f = 0; f < 6; ++f) {
    EXPECT_FALSE(deck.fluids[f].upstream) << f;
    EXPECT_NE(script.find("Q(first(" + std::to_string(2 + f) + ")) = 20.0000000000;"), std::string::npos) << f;
  }
}

TEST_F(DeckFluids, air_comes_before_liquid) {
  spindle = read_spindle(spindles + "four_bearing_milling.toml");
  const DeckModel deck = make_deck_model(spindle, values_of(spindle));
  ASSERT_EQ(deck.fluids.size(), 11u);
  for (std::size_t f = 0; f < 11; ++f) EXPECT_EQ(deck.fluids[f].circuit.has_value(), f >= 3) << deck.fluids[f].name;
  for (const DeckFilm& film : deck.films) {
    if (film.fluid) {
      EXPECT_EQ(deck.fluids[*film.fluid].surrounding, film.surrounding);
    }
  }
}

}  // namespace exchange_files_fluids_test
}  // namespace spindle_twin::fem_offline

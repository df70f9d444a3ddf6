#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "fem_offline/exchange_files/calculix_deck.hpp"
#include "fem_offline/exchange_files/freefem_deck.hpp"
#include "tests/fem_offline/exchange_files/spindle_decks.hpp"

namespace spindle_twin::fem_offline {
namespace exchange_files_growth_test {

using namespace exchange_files_test;

/// What make_deck_model says of two_rings as `spoil` leaves it; growth is then in no row of the deck.
std::string left_out_of(const std::function<void(Spindle&)>& spoil) {
  Spindle spindle = read_spindle(spindles + "two_rings.toml");
  spoil(spindle);
  const DeckModel deck = make_deck_model(spindle, values_of(spindle));
  EXPECT_TRUE(deck.growth_left_out.empty() || (deck.deformations.empty() && deck.supported_nodes.empty()));
  EXPECT_FALSE(deck.elements.empty());
  return deck.growth_left_out;
}

const rom::SourceLine line_7{"s.toml", 7};

TEST(GrowthLeftOut, with_every_support_but_a_face_held_along_z) {
  const Box face{0.020, 0.035, 0.0, 0.0}, point{0.020, 0.020, 0.0, 0.0};
  const auto with = [](const Support& support) {
    return left_out_of([&](Spindle& spindle) { spindle.supports = {support}; });
  };
  const std::string reason =
      "s.toml:7: support: decks know only a face held along z, no point, spring or plane, nothing along r";
  EXPECT_EQ(with({0, face, line_7, Hold::free, Hold::fixed, 0.0, 0.0}), "");
  EXPECT_EQ(with({0, point, line_7, Hold::free, Hold::fixed, 0.0, 0.0}), reason);
  EXPECT_EQ(with({0, face, line_7, Hold::fixed, Hold::fixed, 0.0, 0.0}), reason);
  EXPECT_EQ(with({0, face, line_7, Hold::free, Hold::spring, 0.0, 1e8}), reason);
  EXPECT_EQ(with({0, face, line_7, Hold::free, Hold::plane, 0.0, 0.0}), reason);
}

TEST(GrowthLeftOut, with_outputs_at_points) {
  DeformationOutput output;
  output.name = "growth";
  output.where = line_7;
  output.face = {0.020, 0.035, 0.010, 0.010};
  const auto with = [](const DeformationOutput& asked) {
    return left_out_of([&](Spindle& spindle) { spindle.deformations = {asked}; });
  };
  DeformationOutput at_point = output, difference = output;
  at_point.at = Point{0.020, 0.010};
  EXPECT_EQ(with(at_point), "s.toml:7: growth: decks know only means over a face, no point");
  difference.minus = 0;
  EXPECT_EQ(with(difference), "");
}

/// A shipped spindle's decks for both solvers, in a folder of their own that goes when the test ends.
struct BothDecks {
  explicit BothDecks(const std::string& file)
      : spindle(read_spindle(spindles + file)), deck(make_deck_model(spindle, values_of(spindle))) {
    DeckPlan plan;
    plan.surrounding_K = spindle.operating.surrounding_K;
    write_calculix_deck(spindle, deck, plan, still_fluids(deck), path / "calculix");
    write_freefem_deck(spindle, deck, plan, path / "freefem");
  }
  ~BothDecks() { std::filesystem::remove_all(path); }
  BothDecks(const BothDecks&) = delete;
  BothDecks& operator=(const BothDecks&) = delete;

  Spindle spindle;
  DeckModel deck;
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("growth_test_" + std::to_string(getpid()));
};

TEST(Growth, an_output_less_another_goes_over_as_that) {
  const BothDecks decks("reference_laws.toml");
  const auto& [spindle, deck, path] = decks;
  ASSERT_EQ(deck.growth_left_out, "");
  const auto outputs = nlohmann::json::parse(text_of(path / "calculix" / "outputs.json"))["deformations"];
  std::size_t differences = 0;
  for (std::size_t d = 0; d < spindle.deformations.size(); ++d) {
    const DeformationOutput& output = spindle.deformations[d];
    EXPECT_EQ(outputs[output.name].contains("minus"), output.minus.has_value()) << output.name;
    if (!output.minus) continue;
    ++differences;
    EXPECT_EQ(outputs[output.name]["minus"], spindle.deformations[*output.minus].name);
    const std::regex line("real moved" + std::to_string(d) + " = .* - moved" + std::to_string(*output.minus) + ";");
    EXPECT_TRUE(std::regex_search(text_of(path / "freefem" / "spindle.edp"), line)) << output.name;
  }
  EXPECT_EQ(differences, 3u);
}

/// In FreeFEM a spring as stiff as the model's own ties faces whose nodes do not match.
TEST(Growth, freefem_ties_faces_that_do_not_match_by_springs) {
  const BothDecks decks("belt_driven.toml");
  const auto& [spindle, deck, path] = decks;
  ASSERT_EQ(deck.growth_left_out, "");
  const std::string script = text_of(path / "freefem" / "spindle.edp");
  std::size_t ties = 0;
  for (std::size_t p = 0; p < deck.pairs.size(); ++p) {
    const std::string number = std::to_string(p);
    const bool tied = deck.pairs[p].tie_N_per_m3 > 0.0;
    EXPECT_EQ(tied, deck.pairs[p].kind == PieceKind::contact && !deck.pairs[p].matching);
    EXPECT_EQ(script.find("varf tie" + number + "(") != std::string::npos, tied) << p;
    for (const char* side : {"a", "b"}) {
      const auto strip = path / "freefem" / ("strip_" + number + side + ".msh");
      EXPECT_EQ(std::filesystem::exists(strip), !deck.pairs[p].matching) << p;
    }
    if (!tied) continue;
    ++ties;
    EXPECT_GT(deck.pairs[p].tie_N_per_m3, 1e4 * 25e9 / 0.01);
    EXPECT_LT(deck.pairs[p].tie_N_per_m3, 1e4 * 210e9 / 0.0001);
  }
  EXPECT_GT(ties, 0u);
}

struct Equation {
  std::size_t node = 0;
  std::vector<std::pair<std::size_t, double>> others;  ///< with the sign of a sum that is zero
};

/// Of displacements along r, in bonds.inc.
std::vector<Equation> equations_of(const std::string& bonds) {
  std::vector<Equation> equations;
  std::istringstream lines(std::regex_replace(bonds, std::regex(",\\s+"), " "));
  for (std::string line; std::getline(lines, line);) {
    if (line != "*EQUATION") continue;
    std::size_t terms = 0, node = 0;
    int direction = 0;
    double weight = 0.0;
    lines >> terms >> node >> direction >> weight;
    EXPECT_EQ(weight, 1.0);
    Equation equation{node - 1, {}};
    for (std::size_t i = 1; i < terms; ++i) {
      lines >> node >> direction >> weight;
      equation.others.emplace_back(node - 1, weight);
    }
    if (direction == 1) equations.push_back(equation);
  }
  return equations;
}

/// In CalculiX nodes of the finer face are sums over those of the other: a rigid motion and a turn meet them, no node
/// is tied twice, and no sum leads back to its own node.
TEST(Growth, calculix_ties_faces_that_do_not_match_by_equations) {
  for (const char* name : {"belt_driven.toml", "grinding_40k.toml", "four_bearing_milling.toml"}) {
    const BothDecks decks(name);
    const auto& [spindle, deck, path] = decks;
    std::map<std::size_t, Equation> all;
    bool has_sums = false;
    for (const Equation& equation : equations_of(text_of(path / "calculix" / "bonds.inc"))) {
      EXPECT_TRUE(all.emplace(equation.node, equation).second) << name << " node " << equation.node;
      has_sums = has_sums || equation.others.size() > 1;
      double sum = 1.0, r_m = deck.nodes[equation.node].r_m, z_m = deck.nodes[equation.node].z_m;
      for (const auto& [node, weight] : equation.others) {
        sum += weight;
        r_m += weight * deck.nodes[node].r_m;
        z_m += weight * deck.nodes[node].z_m;
      }
      EXPECT_NEAR(sum, 0.0, 1e-9) << name << " node " << equation.node;
      EXPECT_NEAR(r_m, 0.0, 1e-9) << name << " node " << equation.node;
      EXPECT_NEAR(z_m, 0.0, 1e-9) << name << " node " << equation.node;
    }
    EXPECT_TRUE(has_sums) << name;
    // Equations whose others are all settled settle their node; a ring would stay.
    std::set<std::size_t> open;
    for (const auto& [node, equation] : all) open.insert(node);
    for (bool settled = true; settled;) {
      settled = std::erase_if(open, [&](std::size_t node) {
                  return std::none_of(all[node].others.begin(), all[node].others.end(),
                                      [&](const auto& other) { return open.contains(other.first); });
                }) > 0;
    }
    EXPECT_TRUE(open.empty()) << name << " " << open.size();
  }
}

/// Both strips have a node wherever a side of an element ends on either face.
TEST(Growth, strips_refine_both_faces) {
  const BothDecks decks("belt_driven.toml");
  const auto& [spindle, deck, path] = decks;
  for (std::size_t p = 0; p < deck.pairs.size(); ++p) {
    const DeckPair& pair = deck.pairs[p];
    if (pair.matching) continue;
    for (const bool first : {true, false}) {
      const std::string name = "strip_" + std::to_string(p) + (first ? "a" : "b") + ".msh";
      std::istringstream mesh(text_of(path / "freefem" / name));
      std::size_t points = 0, triangles = 0, borders = 0;
      mesh >> points >> triangles >> borders;
      EXPECT_EQ(triangles + 2, points);
      EXPECT_EQ(borders, points);
      std::vector<Point> places(points / 2);
      for (Point& place : places) {
        double label = 0.0;
        mesh >> place.r_m >> place.z_m >> label;
      }
      for (const DeckSide& side : deck.sides_of_piece[first ? pair.piece_a : pair.piece_b]) {
        const auto [a, b, middle] = nodes_of(deck, side);
        for (const std::size_t node : {a, b}) {
          const Point& at = deck.nodes[node];
          EXPECT_TRUE(std::any_of(
              places.begin(), places.end(),
              [&](const Point& place) { return std::hypot(place.r_m - at.r_m, place.z_m - at.z_m) < 1e-7; }))
              << name << " " << at.r_m << " " << at.z_m;
        }
      }
    }
  }
}

}  // namespace exchange_files_growth_test
}  // namespace spindle_twin::fem_offline

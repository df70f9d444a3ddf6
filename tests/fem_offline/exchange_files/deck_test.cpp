#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <regex>
#include <set>
#include <sstream>

#include "fem_offline/exchange_files/calculix_deck.hpp"
#include "fem_offline/exchange_files/freefem_deck.hpp"
#include "tests/fem_offline/exchange_files/spindle_decks.hpp"

namespace spindle_twin::fem_offline {
namespace exchange_files_deck_test {

using namespace exchange_files_test;

double area_m2(const DeckModel& deck, std::size_t piece) {
  double area = 0.0;
  for (const DeckSide& side : deck.sides_of_piece[piece]) {
    const auto [a, b, middle] = nodes_of(deck, side);
    const Point &from = deck.nodes[a], &to = deck.nodes[b];
    area += 2.0 * std::numbers::pi * deck.nodes[middle].r_m * std::hypot(to.r_m - from.r_m, to.z_m - from.z_m);
  }
  return area;
}

class Decks : public testing::TestWithParam<const char*> {
 protected:
  Decks() : spindle(read_spindle(spindles + GetParam())), deck(make_deck_model(spindle, values_of(spindle))) {
    plan.surrounding_K = spindle.operating.surrounding_K;
    folder = std::filesystem::temp_directory_path() / ("deck_test_" + std::to_string(getpid()) + "_" + GetParam());
  }
  ~Decks() override { std::filesystem::remove_all(folder); }

  std::string written(const std::string& file) const { return text_of(folder / file); }

  Spindle spindle;
  DeckModel deck;
  DeckPlan plan;
  std::filesystem::path folder;
};

TEST_P(Decks, hold_all_heat) {
  double heat_W = 0.0;
  for (const DeckVolumeHeat& heat : deck.volume_heats) {
    heat_W += heat.density_W_per_m3 * deck.section.outlines[heat.part].volume_m3;
  }
  for (const DeckSurfaceHeat& heat : deck.surface_heats) heat_W += heat.flux_W_per_m2 * area_m2(deck, heat.piece);
  const double expected_W = values_of(spindle).heat_W.sum();
  EXPECT_NEAR(heat_W, expected_W, 1e-9 * expected_W);
}

TEST_P(Decks, sides_cover_every_piece_once) {
  std::set<std::pair<std::size_t, std::size_t>> seen;
  for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
    const BoundaryPiece& piece = deck.section.pieces[p];
    const double expected_m2 = std::numbers::pi * (piece.start.r_m + piece.end.r_m) *
                               std::hypot(piece.end.r_m - piece.start.r_m, piece.end.z_m - piece.start.z_m);
    EXPECT_NEAR(area_m2(deck, p), expected_m2, 1e-9) << p;
    for (const DeckSide& side : deck.sides_of_piece[p]) EXPECT_TRUE(seen.emplace(side.element, side.side).second) << p;
  }
}

TEST_P(Decks, key_points_reproduce_their_place) {
  for (std::size_t k = 0; k < deck.key_points.size(); ++k) {
    double sum = 0.0, r_m = 0.0, z_m = 0.0;
    for (const auto& [node, weight] : deck.key_points[k]) {
      sum += weight;
      r_m += weight * deck.nodes[node].r_m;
      z_m += weight * deck.nodes[node].z_m;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_NEAR(r_m, spindle.key_points[k].at.r_m, 1e-12);
    EXPECT_NEAR(z_m, spindle.key_points[k].at.z_m, 1e-12);
  }
  for (std::size_t d = 0; d < deck.deformations.size(); ++d) {
    double sum = 0.0;
    for (const auto& [node, weight] : deck.deformations[d]) sum += weight;
    EXPECT_NEAR(sum, spindle.deformations[d].sign, 1e-12);
  }
}

TEST_P(Decks, calculix_includes_exist_and_every_element_has_a_section) {
  write_calculix_deck(spindle, deck, plan, still_fluids(deck), folder.string());
  const std::regex include("INPUT=(\\S+\\.inc)");
  for (const char* name : {"steady.inp", "transient.inp", "transient_double.inp"}) {
    const std::string text = written(name);
    for (std::sregex_iterator found(text.begin(), text.end(), include), end; found != end; ++found) {
      EXPECT_TRUE(std::filesystem::exists(folder / (*found)[1].str())) << name << ": " << (*found)[1];
    }
  }
  std::istringstream mesh(written("mesh.inc") + written("exchange.inc"));
  std::set<std::string> element_sets, sections;
  std::size_t elements = 0;
  bool in_elements = false;
  const std::regex set("ELSET=(\\w+)");
  for (std::string line; std::getline(mesh, line);) {
    EXPECT_LE(line.size(), 132u) << line;
    std::smatch match;
    if (line[0] == '*') {
      in_elements = line.starts_with("*ELEMENT");
      if (std::regex_search(line, match, set)) (in_elements ? element_sets : sections).insert(match[1]);
    } else if (in_elements) {
      ++elements;
    }
  }
  EXPECT_EQ(element_sets, sections);
  std::size_t gap_elements = 0;
  for (const DeckPair& pair : deck.pairs) {
    if (pair.kind == PieceKind::gap) gap_elements += deck.sides_of_piece[pair.piece_a].size();
  }
  EXPECT_EQ(elements, deck.elements.size() + gap_elements);
  EXPECT_EQ(deck.deformations.empty(), !std::filesystem::exists(folder / "growth_steady.inp"));
  EXPECT_TRUE(std::filesystem::exists(folder / "README"));
}

TEST_P(Decks, freefem_meshes_hold_two_triangles_per_element) {
  write_freefem_deck(spindle, deck, plan, folder.string());
  std::size_t triangles = 0, borders = 0, sides = 0;
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    std::istringstream mesh(written("part_" + std::to_string(part) + ".msh"));
    std::size_t points = 0, of_part = 0, on_border = 0;
    mesh >> points >> of_part >> on_border;
    triangles += of_part;
    borders += on_border;
  }
  for (const auto& on_piece : deck.sides_of_piece) sides += on_piece.size();
  EXPECT_EQ(triangles, 2 * deck.elements.size());
  EXPECT_EQ(borders, sides);
  EXPECT_TRUE(written("spindle.edp").find("report(\"steady\"") != std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Spindles, Decks,
                         testing::Values("two_rings.toml", "shaft_in_sleeve.toml", "reference.toml",
                                         "reference_laws.toml", "jacket_circuit.toml", "belt_driven.toml",
                                         "grinding_40k.toml", "four_bearing_milling.toml"),
                         [](const auto& instance) {
                           const std::string file = instance.param;
                           return file.substr(0, file.find('.'));
                         });

TEST(DeckModel, refuses_elements_of_another_degree) {
  Spindle spindle = read_spindle(spindles + "two_rings.toml");
  spindle.mesh.degree = 1;
  EXPECT_THROW(make_deck_model(spindle, values_of(spindle)), rom::InputError);
}

}  // namespace exchange_files_deck_test
}  // namespace spindle_twin::fem_offline

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <regex>
#include <set>
#include <sstream>

#include "fem_offline/exchange_files/calculix_deck.hpp"
#include "fem_offline/exchange_files/freefem_deck.hpp"

namespace spindle_twin::fem_offline {
namespace exchange_files_deck_test {

const std::string spindles = SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/";

/// 1, 2, 3 ... W and the description's own coefficients.
rom::BoundaryValues values_of(const Spindle& spindle) {
  rom::BoundaryValues values;
  std::vector<double> conductances;
  for (const Contact& contact : spindle.contacts) conductances.push_back(contact.conductance_W_per_m2K);
  for (const GapFilm& gap : spindle.gap_films) conductances.push_back(gap.coefficient_W_per_m2K);
  for (const Film& film : spindle.films) conductances.push_back(film.coefficient_W_per_m2K);
  values.conductance_W_per_m2K =
      Eigen::Map<Eigen::VectorXd>(conductances.data(), static_cast<Eigen::Index>(conductances.size()));
  const auto heats = static_cast<Eigen::Index>(spindle.heats.size());
  values.heat_W = Eigen::VectorXd::LinSpaced(heats, 1.0, static_cast<double>(heats));
  return values;
}

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
    for (const Surrounding& surrounding : spindle.surroundings) {
      if (surrounding.kind == SurroundingKind::air) air.steady_K.push_back(300.0);
    }
    air.time_s = {0.0, 1800.0};
    air.air_K = {air.steady_K, air.steady_K};
    folder = std::filesystem::temp_directory_path() / ("deck_test_" + std::to_string(getpid()) + "_" + GetParam());
  }
  ~Decks() override { std::filesystem::remove_all(folder); }

  std::string text_of(const std::string& file) const {
    std::ifstream stream(folder / file);
    EXPECT_TRUE(stream) << file;
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  Spindle spindle;
  DeckModel deck;
  DeckPlan plan;
  AirHistory air;
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
  write_calculix_deck(spindle, deck, plan, air, folder.string());
  const std::regex include("INPUT=(\\S+\\.inc)");
  for (const char* name : {"steady.inp", "transient.inp", "transient_double.inp"}) {
    const std::string text = text_of(name);
    for (std::sregex_iterator found(text.begin(), text.end(), include), end; found != end; ++found) {
      EXPECT_TRUE(std::filesystem::exists(folder / (*found)[1].str())) << name << ": " << (*found)[1];
    }
  }
  std::istringstream mesh(text_of("mesh.inc") + text_of("exchange.inc"));
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
    std::istringstream mesh(text_of("part_" + std::to_string(part) + ".msh"));
    std::size_t points = 0, of_part = 0, on_border = 0;
    mesh >> points >> of_part >> on_border;
    triangles += of_part;
    borders += on_border;
  }
  for (const auto& on_piece : deck.sides_of_piece) sides += on_piece.size();
  EXPECT_EQ(triangles, 2 * deck.elements.size());
  EXPECT_EQ(borders, sides);
  EXPECT_TRUE(text_of("spindle.edp").find("report(\"steady\"") != std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Spindles, Decks, testing::Values("two_rings.toml", "shaft_in_sleeve.toml", "reference.toml"),
                         [](const auto& instance) {
                           const std::string file = instance.param;
                           return file.substr(0, file.find('.'));
                         });

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

TEST(GrowthLeftOut, with_outputs_at_points_and_of_differences) {
  DeformationOutput output;
  output.name = "growth";
  output.where = line_7;
  output.face = {0.020, 0.035, 0.010, 0.010};
  const auto with = [](const DeformationOutput& asked) {
    return left_out_of([&](Spindle& spindle) { spindle.deformations = {asked}; });
  };
  const std::string reason = "s.toml:7: growth: decks know only the mean over a face, no point and no difference";
  DeformationOutput at_point = output, difference = output;
  at_point.at = Point{0.020, 0.010};
  difference.minus = 0;
  EXPECT_EQ(with(at_point), reason);
  EXPECT_EQ(with(difference), reason);
}

/// A taper's mesh does not match its neighbour's: the heat goes to CalculiX all the same. In FreeFEM it would go wrong.
TEST(GrowthLeftOut, where_the_meshes_of_parts_in_contact_differ) {
  const Spindle spindle = read_spindle(spindles + "belt_driven.toml");
  const DeckModel deck = make_deck_model(spindle, values_of(spindle));
  EXPECT_TRUE(std::regex_search(
      deck.growth_left_out, std::regex("belt_driven.toml:[0-9]+: contact: the meshes of '.+' and '.+' do not match")))
      << deck.growth_left_out;
  const auto folder = std::filesystem::temp_directory_path() / ("growth_left_out_" + std::to_string(getpid()));
  DeckPlan plan;
  plan.surrounding_K = spindle.operating.surrounding_K;
  AirHistory air;
  for (const Surrounding& surrounding : spindle.surroundings) {
    if (surrounding.kind == SurroundingKind::air) air.steady_K.push_back(300.0);
  }
  air.time_s = {0.0, 1800.0};
  air.air_K = {air.steady_K, air.steady_K};
  write_calculix_deck(spindle, deck, plan, air, folder / "calculix");
  EXPECT_TRUE(std::filesystem::exists(folder / "calculix" / "steady.inp"));
  EXPECT_FALSE(std::filesystem::exists(folder / "calculix" / "growth_steady.inp"));
  std::ostringstream text;
  text << std::ifstream(folder / "calculix" / "README").rdbuf();
  EXPECT_NE(text.str().find("Without growth: " + deck.growth_left_out), std::string::npos) << text.str();
  EXPECT_THROW(write_freefem_deck(spindle, deck, plan, folder / "freefem"), rom::InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "freefem"));
  std::filesystem::remove_all(folder);
}

TEST(DeckModel, refuses_elements_of_another_degree) {
  Spindle spindle = read_spindle(spindles + "two_rings.toml");
  spindle.mesh.degree = 1;
  EXPECT_THROW(make_deck_model(spindle, values_of(spindle)), rom::InputError);
}

}  // namespace exchange_files_deck_test
}  // namespace spindle_twin::fem_offline

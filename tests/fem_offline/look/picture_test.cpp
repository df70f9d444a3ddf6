#include "fem_offline/look/picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "fem_offline/look/picture_frame.hpp"
#include "fem_offline/model/build_model.hpp"
#include "tests/fem_offline/description/sample_spindle.hpp"
#include "tests/fem_offline/look/read_image.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::fem_offline {
namespace look_picture_test {

const std::string spindles = SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/";

const FeModel& reference() {
  static const FeModel model = build_fe_model(spindles + "reference.toml");
  return model;
}

double area_of(const Polygon& ring) {
  double twice_m2 = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
    twice_m2 += a.r_m * b.z_m - b.r_m * a.z_m;
  }
  return 0.5 * std::abs(twice_m2);
}

double perimeter_of(const Polygon& ring) {
  double length_m = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
    length_m += std::hypot(b.r_m - a.r_m, b.z_m - a.z_m);
  }
  return length_m;
}

/// A planar bar on a point and springs, with everything on it that the reference spindle has not.
std::string bracket(const std::string& supports) {
  return R"(name = "bracket"
geometry = "planar"
[operating]
speed_rpm = 1000
reference_temperature_degC = 20
temperatures_degC = { room = 22, plate = 60 }
[mesh]
element_size_mm = 5
)" + steel_text +
         R"([[part]]
name = "bar"
material = "steel"
rectangles = [[0, 40, 0, 200]]
[[surrounding]]
name = "room"
kind = "ambient"
[[surrounding]]
name = "plate"
kind = "ambient"
[[film]]
name = "air"
coefficient_W_per_m2K = 10
surrounding = "room"
regions = [[40, 50, 0, 200], [0, 40, 200, 210], [-5, 0, 0, 200]]
[[radiation]]
name = "glow"
surrounding = "room"
emissivity = 0.8
mean_temperature_degC = 60
regions = [[40, 50, 0, 200]]
[[prescribed_temperature]]
name = "foot"
surrounding = "plate"
regions = [[0, 40, -5, 0]]
[[heat]]
name = "lamp"
flux_W_per_m2 = 2000
shares = [{ part = "bar", on_face = [0, 0, 50, 150] }]
)" + supports;
}

const std::string bracket_supports = R"([[support]]
part = "bar"
at = [0, 0]
holds = "rz"
[[support]]
part = "bar"
at = [0, 200]
stiffness_r_N_per_m = 2e8
[[support]]
part = "bar"
face = [0, 40, 200, 200]
stiffness_z_N_per_m = 1e7
[[deformation]]
name = "tip"
part = "bar"
at = [40, 200]
positive_along = "+z"
[[deformation]]
name = "lift"
part = "bar"
at = [40, 200]
positive_along = "+r"
[[deformation]]
name = "stretch"
part = "bar"
at = [40, 0]
positive_along = "-z"
minus = "tip"
[[key_point]]
name = "middle"
part = "bar"
at = [20, 100]
[[stress_probe]]
name = "corner"
part = "bar"
at = [40, 3]
)";

TEST(Lattice, triangles_cover_the_section_once) {
  const Lattice lattice = lattice_of(reference());
  double drawn_m2 = 0.0;
  for (const auto& [a, b, c] : triangles_of(lattice)) {
    drawn_m2 += area_of({lattice.nodes[a], lattice.nodes[b], lattice.nodes[c]});
  }
  double outline_m2 = 0.0;
  for (const PartOutline& outline : reference().section().outlines) {
    for (const OutlineFace& face : outline.faces) {
      outline_m2 += area_of(face.outer);
      for (const Polygon& hole : face.holes) outline_m2 -= area_of(hole);
    }
  }
  EXPECT_NEAR(drawn_m2, outline_m2, 1e-10 * outline_m2);
}

TEST(Lattice, rim_is_the_outline_of_every_part) {
  const Lattice lattice = lattice_of(reference());
  double rim_m = 0.0;
  std::map<int, int> meeting;
  for (const auto& [a, b] : rim_of(lattice)) {
    rim_m += perimeter_of({lattice.nodes[a], lattice.nodes[b]}) / 2.0;
    ++meeting[a];
    ++meeting[b];
  }
  double outline_m = 0.0;
  for (const PartOutline& outline : reference().section().outlines) {
    for (const OutlineFace& face : outline.faces) {
      outline_m += perimeter_of(face.outer);
      for (const Polygon& hole : face.holes) outline_m += perimeter_of(hole);
    }
  }
  EXPECT_NEAR(rim_m, outline_m, 1e-9 * outline_m);
  for (const auto& [node, edges] : meeting) EXPECT_EQ(edges % 2, 0) << "node " << node;
}

TEST(Isoline, of_a_linear_field_lies_on_its_line) {
  const Lattice lattice = lattice_of(reference());
  Eigen::VectorXd field(static_cast<Eigen::Index>(lattice.nodes.size()));
  for (std::size_t i = 0; i < lattice.nodes.size(); ++i) {
    field[static_cast<Eigen::Index>(i)] = 3.0 * lattice.nodes[i].r_m - 2.0 * lattice.nodes[i].z_m;
  }
  const auto pieces = isoline(lattice, triangles_of(lattice), field, -0.1);
  ASSERT_GT(pieces.size(), 10U);
  for (const IsolinePiece& piece : pieces) {
    for (const Point& at : {piece.start, piece.end}) EXPECT_NEAR(3.0 * at.r_m - 2.0 * at.z_m, -0.1, 1e-12);
  }
}

TEST(NiceStep, is_one_two_or_five_and_gives_enough_of_them) {
  for (double span = 1.3e-5; span < 1e6; span *= 1.37) {
    const double step = nice_step(span, 8);
    const double leading = step / std::pow(10.0, std::floor(std::log10(step) + 1e-9));
    EXPECT_TRUE(std::abs(leading - 1.0) < 1e-6 || std::abs(leading - 2.0) < 1e-6 || std::abs(leading - 5.0) < 1e-6)
        << step;
    EXPECT_GE(span / step, 8.0 * (1.0 - 1e-9));
    EXPECT_LE(span / step, 20.0 * (1.0 + 1e-9));
  }
}

TEST(FieldColour, lightness_is_linear_in_the_share) {
  const double dark = lightness_of(field_colour(0.0)), light = lightness_of(field_colour(1.0));
  EXPECT_GT(light - dark, 0.6);
  for (int i = 0; i <= 100; ++i) {
    EXPECT_NEAR(lightness_of(field_colour(0.01 * i)), dark + 0.01 * i * (light - dark), 2e-3);
  }
  EXPECT_EQ(field_colour(-1.0).blue, field_colour(0.0).blue);
  EXPECT_EQ(field_colour(2.0).red, field_colour(1.0).red);
}

TEST(Picture, colour_at_a_place_is_that_of_the_field_there) {
  const Lattice lattice = lattice_of(reference());
  const View view = make_view(lattice.nodes, Geometry::axisymmetric);
  Eigen::VectorXd field(static_cast<Eigen::Index>(lattice.nodes.size()));
  for (std::size_t i = 0; i < lattice.nodes.size(); ++i) field[static_cast<Eigen::Index>(i)] = lattice.nodes[i].z_m;
  Canvas canvas(picture_width_px, static_cast<int>(view.frame.y1) + 10);
  fill_field(canvas, view, lattice.nodes, triangles_of(lattice), field, make_scale(0.0, 0.410));
  const tests::TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path();
  canvas.save(folder / "field.png");
  const Image image(folder / "field.png");
  // The shaft is solid at r = 20 mm from end to end.
  for (const double z_m : {0.01, 0.1, 0.2, 0.3, 0.4}) {
    const Colour seen = image.at(view.at({0.020, z_m})), wanted = field_colour(z_m / 0.410);
    EXPECT_NEAR(seen.red, wanted.red, 0.02);
    EXPECT_NEAR(seen.green, wanted.green, 0.02);
    EXPECT_NEAR(seen.blue, wanted.blue, 0.02);
  }
  // The bore is empty.
  EXPECT_EQ(image.at(view.at({0.007, 0.2})).red, 1.0);
}

/// How many pixels have that colour, to a hundredth; one of four is looked at.
int count_pixels(const Image& image, const Colour& wanted) {
  int count = 0;
  for (int y = 0; y < image.height(); y += 2) {
    for (int x = 0; x < image.width(); x += 2) {
      const Colour seen = image.at({static_cast<double>(x), static_cast<double>(y)});
      const double off = std::max(
          {std::abs(seen.red - wanted.red), std::abs(seen.green - wanted.green), std::abs(seen.blue - wanted.blue)});
      if (off < 0.01) count += 4;
    }
  }
  return count;
}

TEST(Picture, parts_and_rise_of_a_model_are_written_in_their_colours) {
  const tests::TemporaryFolder temporary;
  const AffineModel& affine = reference().affine();
  Eigen::VectorXd warm_K = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(affine.places.size()), 301.15);
  const Lattice lattice = lattice_of(reference());
  for (const LatticeCell& cell : lattice.cells) {
    for (const int node : cell.nodes) warm_K[node] = cell.part == 0 ? 303.15 : 301.15;
  }
  const auto written =
      write_pictures(temporary.path(), "warm", picture_of(reference(), warm_K, {"warm shaft", 300.15}));
  ASSERT_EQ(written.size(), 2U);
  const View view = make_view(lattice.nodes, Geometry::axisymmetric);
  double cells_m2 = 0.0, shaft_m2 = 0.0;
  for (const PartOutline& outline : reference().section().outlines) {
    double area_m2 = 0.0;
    for (const OutlineFace& face : outline.faces) {
      area_m2 += area_of(face.outer);
      for (const Polygon& hole : face.holes) area_m2 -= area_of(hole);
    }
    cells_m2 += area_m2;
    if (&outline == &reference().section().outlines.front()) shaft_m2 = area_m2;
  }
  const double pixels_per_m2 = view.px_per_m * view.px_per_m;
  const Image parts(written[0]), rise(written[1]);
  const FieldScale scale = make_scale(1.0, 3.0);
  const auto colour_of = [&](double rise_K) { return field_colour((rise_K - scale.low) / (scale.high - scale.low)); };
  // All but what lines, marks and letters cover.
  EXPECT_GT(count_pixels(parts, part_colour(0)), 0.6 * shaft_m2 * pixels_per_m2);
  EXPECT_GT(count_pixels(rise, colour_of(3.0)), 0.6 * shaft_m2 * pixels_per_m2);
  EXPECT_GT(count_pixels(rise, colour_of(1.0)), 0.6 * (cells_m2 - shaft_m2) * pixels_per_m2);
}

TEST(Picture, view_holds_all_nodes_and_names_the_axes_of_the_geometry) {
  const std::vector<Point> nodes{{-0.01, 0.0}, {0.04, 0.0}, {0.04, 0.2}, {-0.01, 0.2}};
  const View planar = make_view(nodes, Geometry::planar);
  for (const Point& node : nodes) {
    EXPECT_GT(planar.at(node).x, planar.frame.x0);
    EXPECT_LT(planar.at(node).x, planar.frame.x1);
    EXPECT_GT(planar.at(node).y, planar.frame.y0);
    EXPECT_LT(planar.at(node).y, planar.frame.y1);
  }
  const View round = make_view({{0.01, 0.0}, {0.04, 0.2}}, Geometry::axisymmetric);
  EXPECT_DOUBLE_EQ(round.y(0.0), round.frame.y1);
  DeformationOutput output;
  output.direction = Direction::radial;
  EXPECT_EQ(sense_of(output, planar), "+x");
  EXPECT_EQ(sense_of(output, round), "+r");
  output.direction = Direction::axial;
  output.sign = -1.0;
  EXPECT_EQ(sense_of(output, planar), "−y");
  EXPECT_EQ(sense_of(output, round), "−z");
}

TEST(Picture, letters_of_key_points_are_all_different) {
  std::set<std::string> letters;
  for (std::size_t k = 0; k < 200; ++k) EXPECT_TRUE(letters.insert(letter_of(k)).second) << k;
  EXPECT_EQ(letter_of(0), "A");
  EXPECT_EQ(letter_of(26), "A1");
}

TEST(Picture, point_supports_springs_and_radiation_stand_beside_the_part) {
  const tests::TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path();
  const auto drawn = [&](const std::string& name, const std::string& supports) {
    const Spindle spindle = parse_spindle(bracket(supports), "bracket.toml");
    const FeModel model(spindle, build_section(spindle));
    const Eigen::VectorXd warm_K =
        Eigen::VectorXd::Constant(static_cast<Eigen::Index>(model.affine().places.size()), 300.15);
    return std::pair(write_pictures(folder, name, picture_of(model, warm_K, {"uniform rise", 293.15})),
                     make_view(lattice_of(model).nodes, Geometry::planar));
  };
  const auto [with, view] = drawn("with", bracket_supports);
  const auto without = drawn("without", "").first;
  const Image held(with[0]), loose(without[0]);
  const auto is_dark = [](const Colour& colour) { return colour.red + colour.green + colour.blue < 1.0; };
  // The ground below a held point and behind a spring; nothing without supports.
  const Pixel foot = view.at({0.0, 0.0}), end = view.at({0.02, 0.2});
  for (const Pixel& ground : {Pixel{foot.x, foot.y + 16.0}, Pixel{end.x + 31.0, end.y}}) {
    EXPECT_TRUE(is_dark(held.at(ground)));
    EXPECT_EQ(loose.at(ground).green, 1.0);
  }
  // Dots of radiation outside the film.
  int dots = 0;
  for (double x = view.x(0.05); x < view.x(0.15); x += 1.0) {
    const Colour colour = loose.at({x, view.y(0.04) - 8.0});
    if (colour.red > 0.6 && colour.green < 0.4) ++dots;
  }
  EXPECT_GT(dots, 100);
}

TEST(Picture, unwritable_folder_is_an_error_that_names_the_file) {
  const Eigen::VectorXd warm_K =
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(reference().affine().places.size()), 301.15);
  try {
    write_pictures("/nowhere/at/all", "warm", picture_of(reference(), warm_K, {"", 300.15}));
    FAIL() << "no error";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("/nowhere/at/all/warm_parts.png"), std::string::npos) << error.what();
  }
}

}  // namespace look_picture_test
}  // namespace spindle_twin::fem_offline

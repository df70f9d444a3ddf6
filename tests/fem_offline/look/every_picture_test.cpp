#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "fem_offline/look/picture.hpp"
#include "fem_offline/look/picture_frame.hpp"
#include "fem_offline/model/build_model.hpp"
#include "tests/fem_offline/look/read_image.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::fem_offline {
namespace {

const FeModel& reference() {
  static const FeModel model = build_fe_model(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference.toml");
  return model;
}

/// The reference spindle, warmer by 20 K from its rear end to its nose, drawn in every way.
struct Drawn {
  Drawn() : lattice(lattice_of(reference())), view(make_view(lattice.nodes, Geometry::axisymmetric)) {
    warm_K = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(reference().affine().places.size()), datum_K);
    rises_K.resize(static_cast<Eigen::Index>(lattice.nodes.size()));
    for (std::size_t i = 0; i < lattice.nodes.size(); ++i) {
      rises_K[static_cast<Eigen::Index>(i)] = 20.0 * lattice.nodes[i].z_m / 0.410;
    }
    warm_K.head(rises_K.size()) += rises_K;
    written = write_pictures(folder.path(), "warm", reference(), warm_K, {"linear rise", datum_K});
  }

  const std::string& named(const std::string& kind) const {
    return *std::find_if(written.begin(), written.end(),
                         [&](const std::string& path) { return path.ends_with("_" + kind + ".png"); });
  }

  /// Share of the nodes inside of parts at whose place the picture has the colour that is wanted there; labels and
  /// isolines hide some.
  double share_of_nodes(const std::string& kind, const std::function<Colour(std::size_t)>& wanted) const {
    const Image image(named(kind));
    int met = 0, all = 0;
    for (const LatticeCell& cell : lattice.cells) {
      const auto node = static_cast<std::size_t>(cell.nodes[cell.nodes.size() / 2]);  // the middle one: degree 2
      const Colour seen = image.at(view.at(lattice.nodes[node])), right = wanted(node);
      met += std::abs(seen.red - right.red) < 0.03 && std::abs(seen.green - right.green) < 0.03 &&
             std::abs(seen.blue - right.blue) < 0.03;
      ++all;
    }
    return static_cast<double>(met) / all;
  }

  static std::function<Colour(std::size_t)> colours_of(const Eigen::VectorXd& field) {
    const FieldScale scale = make_scale(field.minCoeff(), field.maxCoeff());
    return [&field, scale](std::size_t node) {
      return field_colour((field[static_cast<Eigen::Index>(node)] - scale.low) / (scale.high - scale.low));
    };
  }

  static constexpr double datum_K = 300.15;
  tests::TemporaryFolder folder;
  Lattice lattice;
  View view;
  Eigen::VectorXd warm_K, rises_K;
  std::vector<std::string> written;
};

/// Drawn once for all tests.
class EveryPicture : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { drawn = std::make_unique<Drawn>(); }
  static void TearDownTestSuite() { drawn.reset(); }
  static std::unique_ptr<Drawn> drawn;
};
std::unique_ptr<Drawn> EveryPicture::drawn;

TEST_F(EveryPicture, of_the_rise_has_the_colours_of_the_rises) {
  EXPECT_GT(drawn->share_of_nodes("rise", Drawn::colours_of(drawn->rises_K)), 0.8);
  const Eigen::VectorXd elsewhere_K = drawn->rises_K.reverse();
  EXPECT_LT(drawn->share_of_nodes("rise", Drawn::colours_of(elsewhere_K)), 0.3) << "the check sees another field";
}

TEST_F(EveryPicture, of_the_stress_has_the_colours_of_the_von_mises_stress) {
  const Eigen::MatrixXd stresses_Pa = reference().stresses_Pa(drawn->warm_K);
  Eigen::VectorXd von_mises(drawn->rises_K.size());
  for (Eigen::Index i = 0; i < von_mises.size(); ++i)
    von_mises[i] = 1e-6 * von_mises_Pa(stress_from(stresses_Pa.row(i)));
  EXPECT_GT(drawn->share_of_nodes("stress", Drawn::colours_of(von_mises)), 0.8);
}

TEST_F(EveryPicture, of_the_parts_has_most_of_each_part_in_its_colour) {
  std::map<std::size_t, std::size_t> part_of;
  for (const LatticeCell& cell : drawn->lattice.cells)
    part_of[static_cast<std::size_t>(cell.nodes[cell.nodes.size() / 2])] = cell.part;
  const auto in_part = [&](std::size_t node) { return part_colour(part_of.at(node)); };
  EXPECT_GT(drawn->share_of_nodes("parts", in_part), 0.5);
}

TEST_F(EveryPicture, of_the_mesh_has_a_line_along_each_side_of_an_element) {
  const Image image(drawn->named("mesh"));
  int lines = 0, sides = 0;
  for (const auto& [a, b] : edges_of(drawn->lattice, false)) {
    const Point &from = drawn->lattice.nodes[static_cast<std::size_t>(a)],
                &to = drawn->lattice.nodes[static_cast<std::size_t>(b)];
    const Pixel middle = drawn->view.at({0.5 * (from.r_m + to.r_m), 0.5 * (from.z_m + to.z_m)});
    double darkest = 3.0;
    for (const double aside : {-1.0, 0.0, 1.0}) {
      for (const double along : {-1.0, 0.0, 1.0}) {
        const Colour colour = image.at({middle.x + along, middle.y + aside});
        darkest = std::min(darkest, colour.red + colour.green + colour.blue);
      }
    }
    lines += darkest < 1.9;
    ++sides;
  }
  EXPECT_GT(lines, 0.95 * sides) << "the axes' labels hide a few";
}

TEST_F(EveryPicture, of_the_deformed_shape_is_that_of_its_own_field) {
  const tests::TemporaryFolder other;
  Eigen::VectorXd even_K = drawn->warm_K;
  even_K.setConstant(Drawn::datum_K + 20.0);
  const auto even = write_pictures(other.path(), "warm", reference(), even_K, {"linear rise", Drawn::datum_K});
  const Image one(drawn->named("deformed")), two(even[3]);
  ASSERT_TRUE(even[3].ends_with("_deformed.png"));
  long differing = 0;
  for (int y = static_cast<int>(drawn->view.frame.y0); y < static_cast<int>(drawn->view.frame.y1); ++y) {
    for (int x = static_cast<int>(drawn->view.frame.x0); x < static_cast<int>(drawn->view.frame.x1); ++x) {
      const Pixel at{static_cast<double>(x), static_cast<double>(y)};
      differing += std::abs(one.at(at).red - two.at(at).red) > 0.2;
    }
  }
  EXPECT_GT(differing, 5000);
}

}  // namespace
}  // namespace spindle_twin::fem_offline

// Contact and bonding of meshes that do not match.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>
#include <random>

#include "fem_offline/model/discretisation.hpp"
#include "fem_offline/model/exchange_terms.hpp"
#include "fem_offline/model/thermoelastic.hpp"
#include "fem_offline/model/volume_terms.hpp"
#include "tests/verification/concentric_rings.hpp"

namespace spindle_twin::fem_offline {
namespace model_common_refinement_test {

/// One column of quads per ring with its own division along z.
void add_ring(SectionMesh& mesh, std::size_t part, double r0_m, double r1_m, int columns,
              const std::vector<double>& z_m) {
  const std::size_t first = mesh.points.size();
  for (const double z : z_m) {
    for (int i = 0; i <= columns; ++i) mesh.points.push_back({r0_m + (r1_m - r0_m) * i / columns, z});
  }
  const auto width = static_cast<std::size_t>(columns) + 1;
  for (std::size_t j = 0; j + 1 < z_m.size(); ++j) {
    for (std::size_t i = 0; i + 1 < width; ++i) {
      const std::size_t corner = first + j * width + i;
      mesh.quads.push_back({corner, corner + 1, corner + width + 1, corner + width});
      mesh.part_of_quad.push_back(part);
    }
  }
}

const std::vector<double> inner_z_m = {0.0, 0.004, 0.013, 0.021, 0.03};
const std::vector<double> outer_z_m = {0.0, 0.01, 0.0171, 0.03};

SectionMesh non_matching() {
  SectionMesh mesh;
  add_ring(mesh, 0, 0.0, 0.02, 2, inner_z_m);
  add_ring(mesh, 1, 0.02, 0.04, 2, outer_z_m);
  return mesh;
}

/// Value at z of the piecewise quadratic field on r = 20 mm, from the places of the part's unknowns alone.
double trace_value(const Discretisation<2>& discretisation, const Eigen::VectorXd& field, int part,
                   const std::vector<double>& lines_m, double z_m) {
  std::size_t e = 0;
  while (e + 2 < lines_m.size() && z_m > lines_m[e + 1]) ++e;
  const double nodes_m[3] = {lines_m[e], 0.5 * (lines_m[e] + lines_m[e + 1]), lines_m[e + 1]};
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    double lagrange = 1.0;
    for (int m = 0; m < 3; ++m) {
      if (m != k) lagrange *= (z_m - nodes_m[m]) / (nodes_m[k] - nodes_m[m]);
    }
    for (std::size_t i = 0; i < discretisation.places.size(); ++i) {
      const DofPlace& place = discretisation.places[i];
      if (place.part != part || std::abs(place.r_m - 0.02) > 1e-12 || std::abs(place.z_m - nodes_m[k]) > 1e-12)
        continue;
      sum += lagrange * field[static_cast<Eigen::Index>(i)];
    }
  }
  return sum;
}

/// uᵀ K u against ∫ (u_A − u_B)² dA by Gauss points on a hand-made list of intervals, for random fields.
TEST(CommonRefinement, contact_integral_is_exact_for_any_two_fields) {
  const Spindle spindle = shaft_in_sleeve();
  const Section section = build_section(spindle);
  const Discretisation<2> discretisation(non_matching(), 2);
  const SurfaceRules rules = make_surface_rules(discretisation, spindle, section);
  const auto n = static_cast<int>(discretisation.places.size());
  const ExchangeTerms terms = exchange_terms(spindle, section, rules, n, {-1});
  EXPECT_NEAR(terms.conductances[0].area_m2, 2.0 * std::numbers::pi * 0.02 * 0.03, 1e-15);

  const unsigned seed = 7;
  std::cout << "seed " << seed << "\n";
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::VectorXd field(n);
  for (double& value : field) value = uniform(random);

  std::vector<double> breaks_m = inner_z_m;
  breaks_m.insert(breaks_m.end(), outer_z_m.begin(), outer_z_m.end());
  std::sort(breaks_m.begin(), breaks_m.end());
  double integral = 0.0;
  for (std::size_t i = 0; i + 1 < breaks_m.size(); ++i) {
    const double half_m = 0.5 * (breaks_m[i + 1] - breaks_m[i]), middle_m = breaks_m[i] + half_m;
    for (const auto& [at, weight] :
         {std::pair{-std::sqrt(0.6), 5.0 / 9.0}, {0.0, 8.0 / 9.0}, {std::sqrt(0.6), 5.0 / 9.0}}) {
      const double z_m = middle_m + at * half_m;
      const double jump =
          trace_value(discretisation, field, 0, inner_z_m, z_m) - trace_value(discretisation, field, 1, outer_z_m, z_m);
      integral += weight * half_m * 2.0 * std::numbers::pi * 0.02 * jump * jump;
    }
  }
  EXPECT_NEAR(field.dot(terms.matrices_m2[0] * field), integral, 1e-12 * integral);
}

/// Growth of two bonded, unequally heated rings whose meshes do not match.
double growth_m(const Discretisation<2>& discretisation, double tie_factor) {
  Spindle spindle = shaft_in_sleeve();
  spindle.materials[1].youngs_modulus_Pa = 100e9;
  spindle.supports.resize(1);
  spindle.supports[0].face = {0.0, 0.02, 0.0, 0.0};
  DeformationOutput tip;
  tip.name = "tip";
  tip.face = {0.0, 0.02, 0.03, 0.03};
  spindle.deformations = {tip};
  const Section section = build_section(spindle);
  const SurfaceRules rules = make_surface_rules(discretisation, spindle, section);
  const ElasticTerms terms = elastic_terms<2>(discretisation, spindle);
  const ElasticSolver solver(bond_and_support(spindle, section, rules, discretisation.places, terms, tie_factor));
  Eigen::VectorXd rise_K(static_cast<Eigen::Index>(discretisation.places.size()));
  for (Eigen::Index i = 0; i < rise_K.size(); ++i) {
    const DofPlace& place = discretisation.places[static_cast<std::size_t>(i)];
    rise_K[i] = place.part == 0 ? 10.0 + 200.0 * place.z_m : 2.0;
  }
  return deformation_rows(spindle, section, rules, discretisation, solver)[0].row_m_per_K.dot(rise_K);
}

std::vector<double> divided(int cells) {
  std::vector<double> z_m;
  for (int j = 0; j <= cells; ++j) z_m.push_back(0.03 * j / cells);
  return z_m;
}

TEST(Bond, growth_does_not_depend_on_the_tie_stiffness) {
  const Discretisation<2> discretisation(non_matching(), 2);
  const double usual_m = growth_m(discretisation, 1e4);
  EXPECT_GT(usual_m, 1e-6);
  EXPECT_NEAR(growth_m(discretisation, 1e3), usual_m, 1e-3 * usual_m);
  EXPECT_NEAR(growth_m(discretisation, 1e5), usual_m, 1e-3 * usual_m);
}

TEST(Bond, tied_meshes_come_to_the_merged_ones) {
  SectionMesh matching, tied;
  add_ring(matching, 0, 0.0, 0.02, 8, divided(12));
  add_ring(matching, 1, 0.02, 0.04, 8, divided(12));
  add_ring(tied, 0, 0.0, 0.02, 8, divided(12));
  add_ring(tied, 1, 0.02, 0.04, 8, divided(11));
  const double merged_m = growth_m(Discretisation<2>(matching, 2), 1e4);
  EXPECT_NEAR(growth_m(Discretisation<2>(tied, 2), 1e4), merged_m, 2e-3 * merged_m);
}

}  // namespace model_common_refinement_test
}  // namespace spindle_twin::fem_offline

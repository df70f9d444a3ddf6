// Properties of the affine terms: symmetry, conservation, areas, shares.
#include "fem_offline/model/affine_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem_offline/description/model_places.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/model/exchange_terms.hpp"
#include "tests/verification/concentric_rings.hpp"
#include "tests/verification/nominal.hpp"

namespace spindle_twin::fem_offline {
namespace model_affine_model_test {

using std::numbers::pi;

double largest(const SparseMatrix& matrix) { return matrix.coeffs().abs().maxCoeff(); }

double asymmetry(const SparseMatrix& matrix) {
  const SparseMatrix transposed = matrix.transpose();
  return (matrix - transposed).norm() / matrix.norm();
}

double largest_row_sum(const SparseMatrix& matrix) {
  return (matrix * Eigen::VectorXd::Ones(matrix.cols())).cwiseAbs().maxCoeff();
}

class ReferenceModel : public testing::Test {
 protected:
  static void SetUpTestSuite() { model_ = new FeModel(build_fe_model(spindle_file("reference"))); }
  static void TearDownTestSuite() {
    delete model_;
    model_ = nullptr;
  }
  const AffineModel& model() const { return model_->affine(); }
  const Spindle& description() const { return model_->description(); }

 private:
  static FeModel* model_;
};
FeModel* ReferenceModel::model_ = nullptr;

TEST_F(ReferenceModel, all_matrices_are_symmetric) {
  EXPECT_LT(asymmetry(model().capacity_J_per_K), 1e-14);
  EXPECT_LT(asymmetry(model().conduction_W_per_K), 1e-14);
  for (const SparseMatrix& term : model().conductance_terms_m2) EXPECT_LT(asymmetry(term), 1e-14);
}

TEST_F(ReferenceModel, exchange_between_bodies_conserves_heat) {
  EXPECT_LT(largest_row_sum(model().conduction_W_per_K), 1e-12 * largest(model().conduction_W_per_K));
  for (std::size_t j = 0; j < model().conductance_terms_m2.size(); ++j) {
    const SparseMatrix& term = model().conductance_terms_m2[j];
    if (model().boundaries.conductances[j].environment >= 0) continue;
    EXPECT_LT(largest_row_sum(term), 1e-12 * largest(term)) << model().boundaries.conductances[j].name;
  }
}

TEST_F(ReferenceModel, order_is_contacts_gap_films_films) {
  const auto& conductances = model().boundaries.conductances;
  ASSERT_EQ(conductances.size(), model().conductance_terms_m2.size());
  for (std::size_t j = 0; j + 1 < conductances.size(); ++j) {
    const auto rank = [](rom::ConductanceKind kind) {
      return kind == rom::ConductanceKind::contact ? 0 : kind == rom::ConductanceKind::gap_film ? 1 : 2;
    };
    EXPECT_LE(rank(conductances[j].kind), rank(conductances[j + 1].kind));
  }
}

TEST_F(ReferenceModel, conductances_stand_where_model_places_says) {
  const auto& conductances = model().boundaries.conductances;
  const Spindle& spindle = description();
  ASSERT_EQ(conductances.size(), conductance_of_film(spindle, spindle.films.size()));
  for (std::size_t i = 0; i < spindle.contacts.size(); ++i) {
    const rom::Conductance& contact = conductances[conductance_of_contact(spindle, i)];
    EXPECT_EQ(contact.kind, rom::ConductanceKind::contact);
    EXPECT_EQ(contact.part_a, static_cast<int>(spindle.contacts[i].part_a));
    EXPECT_EQ(contact.part_b, static_cast<int>(spindle.contacts[i].part_b));
  }
  for (std::size_t i = 0; i < spindle.gap_films.size(); ++i) {
    EXPECT_EQ(conductances[conductance_of_gap_film(spindle, i)].name, spindle.gap_films[i].name);
  }
  for (std::size_t i = 0; i < spindle.films.size(); ++i) {
    EXPECT_EQ(conductances[conductance_of_film(spindle, i)].name, spindle.films[i].name);
    EXPECT_EQ(conductances[conductance_of_film(spindle, i)].environment,
              environment_of(spindle, spindle.films[i].surrounding));
  }
}

TEST_F(ReferenceModel, films_to_environments_sum_to_their_area) {
  for (std::size_t j = 0; j < model().conductance_terms_m2.size(); ++j) {
    const rom::Conductance& conductance = model().boundaries.conductances[j];
    if (conductance.environment < 0) continue;
    EXPECT_NEAR(model().conductance_terms_m2[j].sum(), conductance.area_m2, 1e-12);
    if (conductance.name != "shaft_bore") continue;
    EXPECT_NEAR(conductance.area_m2, 2.0 * pi * 0.014 * 0.410, 1e-12);
  }
}

TEST_F(ReferenceModel, gap_area_is_counted_at_the_mean_radius) {
  for (const rom::Conductance& conductance : model().boundaries.conductances) {
    if (conductance.kind != rom::ConductanceKind::gap_film) continue;
    EXPECT_NEAR(conductance.area_m2, 2.0 * pi * 0.04025 * 0.110, 1e-12);
  }
}

TEST_F(ReferenceModel, heat_distributions_sum_to_one) {
  for (Eigen::Index s = 0; s < model().source_distribution.cols(); ++s) {
    EXPECT_NEAR(model().source_distribution.col(s).sum(), 1.0, 1e-14);
  }
}

TEST_F(ReferenceModel, air_volumes_are_the_last_unknowns_with_their_capacity) {
  ASSERT_EQ(model().air_names.size(), 2U);
  const auto n = static_cast<int>(model().places.size());
  EXPECT_GE(model().places[static_cast<std::size_t>(n - 3)].part, 0);
  EXPECT_EQ(model().places[static_cast<std::size_t>(n - 2)].part, -1);
  EXPECT_DOUBLE_EQ(model().capacity_J_per_K.coeff(n - 2, n - 2), 0.35);
  EXPECT_DOUBLE_EQ(model().capacity_J_per_K.coeff(n - 1, n - 1), 0.25);
}

TEST_F(ReferenceModel, means_and_key_points_reproduce_a_linear_field) {
  Eigen::VectorXd field(static_cast<Eigen::Index>(model().places.size()));
  for (Eigen::Index i = 0; i < field.size(); ++i) {
    field[i] = 1.0 + 3.0 * model().places[static_cast<std::size_t>(i)].z_m;
  }
  for (const FeKeyPoint& point : model().key_points) {
    EXPECT_NEAR(point.row.dot(field), 1.0 + 3.0 * point.at.z_m, 1e-12);
  }
  EXPECT_NEAR(part_named(model(), "rotor").mean_row.dot(field), 1.0 + 3.0 * 0.215, 1e-12);
}

TEST(AffineModel, capacity_sums_to_mass_times_heat_capacity) {
  const Spindle spindle = shaft_in_sleeve();
  const FeModel model(spindle, build_section(spindle));
  const double shaft_J_per_K = 7830.0 * 450.0 * pi * 0.02 * 0.02 * 0.03;
  const double sleeve_J_per_K = 7830.0 * 460.0 * pi * (0.04 * 0.04 - 0.02 * 0.02) * 0.03;
  EXPECT_NEAR(model.affine().capacity_J_per_K.sum(), shaft_J_per_K + sleeve_J_per_K, 1e-10);
}

/// Lamé: GCr15 ring 37..40 mm in a 45 steel ring 40..50 mm: 0.3109345 MPa per µm; 4 µm at assembly; inner ring hotter
/// by 5 K: 1.9899809 MPa.
TEST(JointFit, pressure_follows_lame) {
  Material inner = steel("GCr15", 44.0), outer = steel("steel 45", 48.0);
  inner.youngs_modulus_Pa = 219e9;
  inner.poisson_ratio = 0.3;
  inner.expansion_per_K = 1.20e-5;
  const rom::JointFit fit = joint_fit({0.037, 0.040, 0.050, 4e-6}, inner, outer);
  EXPECT_NEAR(fit.assembly_pressure_Pa, 1.243738049596e6, 1e-3);
  EXPECT_NEAR(fit.assembly_pressure_Pa + 5.0 * fit.pressure_per_inner_rise_Pa_per_K, 1.989980879354e6, 1e-3);
  EXPECT_NEAR(fit.pressure_per_outer_rise_Pa_per_K / fit.pressure_per_inner_rise_Pa_per_K, 1.17 / 1.20, 1e-12);
}

}  // namespace model_affine_model_test
}  // namespace spindle_twin::fem_offline

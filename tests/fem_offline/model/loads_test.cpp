// Heat and exchange terms of fluxes, radiation beside films, and initial temperatures.
#include <gtest/gtest.h>

#include <numbers>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace model_loads_test {

const std::string ring_text = R"(name = "ring"
[operating]
speed_rpm = 1000
reference_temperature_degC = 20
temperatures_degC = { room = 20 }
)" + steel_text + R"([[part]]
name = "inner"
material = "steel"
rectangles = [[20, 30, 0, 10]]
initial_degC = 70
[[part]]
name = "outer"
material = "steel"
rectangles = [[30, 40, 0, 10]]
[[contact]]
between = ["inner", "outer"]
conductance_W_per_m2K = 1000
[[surrounding]]
name = "room"
kind = "ambient"
[[film]]
name = "air"
coefficient_W_per_m2K = 10
surrounding = "room"
regions = [[40, 50, 0, 10]]
[[radiation]]
name = "glow"
surrounding = "room"
emissivity = 1.0
mean_temperature_degC = 26.85
regions = [[40, 50, 0, 4], [0, 40, 10, 20]]
only_parts = ["outer"]
[[adiabatic]]
name = "rest"
regions = [[0, 20, 0, 10], [20, 40, -1, 0], [20, 30, 10, 11], [30, 35, 10, 11]]
[[heat]]
name = "friction"
flux_W_per_m2 = 500
shares = [{ part = "inner", on_face = [20, 20, 0, 10] }, { part = "outer", on_contact_with = "inner", weight = 2 }]
)";

FeModel ring() {
  const Spindle spindle = parse_spindle(ring_text, "ring.toml");
  return {spindle, build_section(spindle)};
}

TEST(Flux, heat_is_flux_times_area_times_weight_and_lands_where_it_acts) {
  const FeModel fe = ring();
  const AffineModel& model = fe.affine();
  const double bore_W = 500.0 * 2.0 * std::numbers::pi * 0.02 * 0.01;
  const double contact_W = 2.0 * 500.0 * 2.0 * std::numbers::pi * 0.03 * 0.01;
  EXPECT_NEAR(model.boundaries.sources[0].nominal_W, bore_W + contact_W, 1e-12);
  double inner = 0.0;
  for (const int dof : model.parts[0].dofs) inner += model.source_distribution(dof, 0);
  EXPECT_NEAR(inner, bore_W / (bore_W + contact_W), 1e-12);
}

/// On the outside over 4 mm beside the film; on the end from 30 to 35 mm beside the adiabatic region, and alone from
/// there to 40 mm.
TEST(Radiation, acts_beside_a_film_beside_an_adiabatic_region_and_alone) {
  const FeModel fe = ring();
  const auto& conductances = fe.affine().boundaries.conductances;
  ASSERT_EQ(conductances.size(), 3u);
  EXPECT_EQ(conductances[1].name, "air");
  EXPECT_NEAR(conductances[1].area_m2, 2.0 * std::numbers::pi * 0.04 * 0.01, 1e-15);
  EXPECT_EQ(conductances[2].name, "glow");
  const double ends_m2 = std::numbers::pi * (0.04 * 0.04 - 0.03 * 0.03);
  EXPECT_NEAR(conductances[2].area_m2, 2.0 * std::numbers::pi * 0.04 * 0.004 + ends_m2, 1e-15);
  EXPECT_NEAR(conductances[2].nominal_W_per_m2K, 4.0 * 5.670374419e-8 * 2.7e7, 1e-12);
}

TEST(InitialTemperature, parts_start_at_their_own_and_all_else_with_the_rest) {
  const FeModel fe = ring();
  const FeStepper stepper(fe.affine());
  for (const int dof : fe.affine().parts[0].dofs) EXPECT_EQ(stepper.temperatures_K()[dof], 343.15);
  for (const int dof : fe.affine().parts[1].dofs) EXPECT_EQ(stepper.temperatures_K()[dof], 293.15);
  const Eigen::VectorXd start_K = initial_temperatures(fe.affine(), 300.0);
  EXPECT_EQ(start_K[fe.affine().parts[0].dofs[0]], 343.15);
  EXPECT_EQ(start_K[fe.affine().parts[1].dofs[0]], 300.0);
}

}  // namespace model_loads_test
}  // namespace spindle_twin::fem_offline

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "fem_offline/solve/coolant_coupling.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "fem_offline/solve/held_system.hpp"
#include "fem_offline/solve/thermal_system.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace solve_coolant_test {

constexpr int lumps = 6;

/// Six lumps in a row, each wetted by its segment of one circuit; the ends lose a little to the room. Symmetric.
AffineModel row_of_lumps(double flow_kg_per_s) {
  AffineModel model;
  Eigen::MatrixXd capacity = Eigen::MatrixXd::Zero(lumps, lumps), conduction = capacity, room = capacity;
  for (int i = 0; i < lumps; ++i) capacity(i, i) = 400.0;
  for (int i = 0; i + 1 < lumps; ++i) {
    conduction(i, i) += 15.0;
    conduction(i + 1, i + 1) += 15.0;
    conduction(i, i + 1) = conduction(i + 1, i) = -15.0;
  }
  room(0, 0) = room(lumps - 1, lumps - 1) = 0.03;
  model.capacity_J_per_K = capacity.sparseView();
  model.conduction_W_per_K = conduction.sparseView();
  model.conductance_terms_m2 = {room.sparseView()};
  model.places.resize(lumps);
  model.source_distribution = Eigen::VectorXd::Constant(lumps, 1.0 / lumps);
  rom::Boundaries& boundaries = model.boundaries;
  boundaries.reference_speed_rpm = 1000.0;
  boundaries.reference_temperature_K = 295.0;
  boundaries.environments = {{"room", rom::EnvironmentKind::ambient}, {"inlet", rom::EnvironmentKind::coolant}};
  boundaries.sources = {{"heat", 300.0, {}}};
  rom::Conductance film;
  film.name = "room";
  film.nominal_W_per_m2K = 10.0;
  film.area_m2 = 0.06;
  film.environment = 0;
  boundaries.conductances = {film};
  boundaries.circuits = {{"jacket", 1, 4180.0, {}}};
  for (int i = 0; i < lumps; ++i) {
    Eigen::MatrixXd wetted = Eigen::MatrixXd::Zero(lumps, lumps);
    wetted(i, i) = 0.01;
    model.conductance_terms_m2.push_back(wetted.sparseView());
    film.name = "groove_" + std::to_string(i);
    film.nominal_W_per_m2K = 1500.0;
    film.area_m2 = 0.01;
    film.environment = 1;
    boundaries.circuits[0].segments.push_back(static_cast<int>(boundaries.conductances.size()));
    boundaries.conductances.push_back(film);
  }
  boundaries.operating.environment_K = Eigen::Vector2d(297.0, 293.0);
  boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, flow_kg_per_s);
  return model;
}

rom::BoundaryValues values_of(const AffineModel& model) {
  rom::BoundaryValues values = rom::make_boundary_values(model.boundaries);
  rom::evaluate_boundaries(model.boundaries, model.boundaries.operating, rom::no_correction(model.boundaries), values);
  return values;
}

/// The lumps and the liquid as one dense system, written down independently: liquid temperatures are unknowns that hold
/// their own balance W (T_out − T_in) = G (T_wall − T_in). Returns K and f of K T = f with the liquid eliminated.
std::pair<Eigen::MatrixXd, Eigen::VectorXd> dense_system(const AffineModel& model, double flow_kg_per_s) {
  const double flow_W_per_K = std::abs(flow_kg_per_s) * 4180.0;
  const double share = 1.0 - std::exp(-15.0 / flow_W_per_K), heat_W_per_K = flow_W_per_K * share;
  Eigen::MatrixXd matrix =
      Eigen::MatrixXd(model.conduction_W_per_K) + 10.0 * Eigen::MatrixXd(model.conductance_terms_m2[0]);
  Eigen::VectorXd drive = Eigen::VectorXd::Constant(lumps, 50.0);
  drive[0] += 0.3 * 297.0;
  drive[lumps - 1] += 0.3 * 297.0;
  // T_in = a + b·T along the flow.
  double a_K = 293.0;
  Eigen::RowVectorXd b = Eigen::RowVectorXd::Zero(lumps);
  for (int k = 0; k < lumps; ++k) {
    const int i = flow_kg_per_s > 0.0 ? k : lumps - 1 - k;
    matrix(i, i) += heat_W_per_K;
    matrix.row(i) -= heat_W_per_K * b;
    drive[i] += heat_W_per_K * a_K;
    a_K *= 1.0 - share;
    b *= 1.0 - share;
    b[i] += share;
  }
  return {matrix, drive};
}

TEST(CoolantSteady, equals_the_dense_solution) {
  for (const double flow_kg_per_s : {0.01, -0.01, 1e-4, 0.5}) {
    const AffineModel model = row_of_lumps(flow_kg_per_s);
    const auto [matrix, drive] = dense_system(model, flow_kg_per_s);
    const Eigen::VectorXd should_be_K = matrix.partialPivLu().solve(drive);
    const Eigen::VectorXd is_K = solve_steady(model, values_of(model));
    EXPECT_LT((is_K - should_be_K).lpNorm<Eigen::Infinity>(), 1e-9 * (should_be_K.maxCoeff() - 290.0));
  }
}

TEST(CoolantSteady, liquid_carries_off_what_it_takes_and_all_heat_leaves) {
  for (const double flow_kg_per_s : {0.01, -0.01, 1e-3, 0.5}) {
    const AffineModel model = row_of_lumps(flow_kg_per_s);
    const rom::BoundaryValues values = values_of(model);
    const Eigen::VectorXd temperatures_K = solve_steady(model, values);
    const rom::CoolantOutlets outlets = coolant_outlets(model, values, temperatures_K);
    EXPECT_NEAR(std::abs(flow_kg_per_s) * 4180.0 * (outlets.outlet_K[0] - 293.0), outlets.heat_W[0], 300e-9);
    const HeatBalance balance = heat_balance(model, values, temperatures_K);
    EXPECT_NEAR(balance.heat_in_W, balance.heat_out_W, 1e-9 * balance.heat_in_W);
    EXPECT_GT(outlets.heat_W[0], 10.0);
  }
}

/// Along the flow each segment warms the liquid by its heat over the flow's capacity, the last one up to the outlet.
TEST(CoolantSteady, liquid_enters_each_segment_warmed_by_those_before) {
  for (const double flow_kg_per_s : {0.02, -0.02}) {
    const AffineModel model = row_of_lumps(flow_kg_per_s);
    const rom::BoundaryValues values = values_of(model);
    const Eigen::VectorXd field = solve_steady(model, values);
    CoolantCoupling coupling(model);
    coupling.hold(values);
    const Eigen::VectorXd entering_K = coupling.entering_K(field);
    ASSERT_EQ(entering_K.size(), lumps);
    double liquid_K = 293.0;
    for (int i = 0; i < lumps; ++i) {
      const int segment = flow_kg_per_s > 0.0 ? i : lumps - 1 - i;
      EXPECT_NEAR(entering_K[segment], liquid_K, 1e-10) << segment;
      const double heat_W = values.conductance_W_per_m2K[1 + segment] * 0.01 * (field[segment] - liquid_K);
      liquid_K += heat_W / (0.02 * 4180.0);
    }
    EXPECT_NEAR(liquid_K, coolant_outlets(model, values, field).outlet_K[0], 1e-10);
  }
}

/// All loads in one pass over the factor, liquid and all, give what each gives alone.
TEST(CoupledFactor, solves_columns_at_once_as_one_by_one) {
  const AffineModel model = row_of_lumps(0.008);
  const rom::BoundaryValues values = values_of(model);
  ThermalSystem system(model);
  system.set_conductances(values.conductance_W_per_m2K);
  CoolantCoupling coupling(model);
  coupling.hold(values);
  CoupledFactor factor(CholeskyFactor(system.combined_lower(20.0)), coupling, 20.0);
  Eigen::MatrixXd loads_W(lumps, 3);
  for (Eigen::Index i = 0; i < loads_W.size(); ++i) loads_W(i) = std::sin(1.0 + static_cast<double>(i));
  const Eigen::MatrixXd together = factor.solve(loads_W, coupling);
  Eigen::VectorXd alone;
  for (Eigen::Index column = 0; column < 3; ++column) {
    factor.solve(loads_W.col(column), coupling, alone);
    EXPECT_LT((together.col(column) - alone).norm(), 1e-12 * alone.norm()) << column;
    EXPECT_GT(coupling.fed_K(alone).norm(), 1e-3 * alone.norm()) << "the liquid carries something on";
  }
}

/// f − A T is nothing at the steady field, and elsewhere what load and conducted heat say apart, liquid and all.
TEST(HeldSystem, warms_nothing_at_the_steady_field) {
  const AffineModel model = row_of_lumps(0.008);
  const rom::BoundaryValues values = values_of(model);
  constexpr double datum_K = 290.0;
  HeldSystem system(model);
  system.hold(values, datum_K);
  Eigen::MatrixXd rises_K(lumps, 2);
  rises_K.col(0) = solve_steady(model, values).array() - datum_K;
  rises_K.col(1).setLinSpaced(lumps, -1.0, 2.0);
  Eigen::VectorXd heat_W;
  system.net_heat_W(rises_K.col(0), heat_W);
  EXPECT_LT(heat_W.norm(), 1e-9 * system.load_W().norm());
  system.net_heat_W(rises_K.col(1), heat_W);
  EXPECT_GT(heat_W.norm(), 0.1 * system.load_W().norm());
  EXPECT_LT((heat_W - (system.load_W() - system.conducted_W(rises_K).col(1))).norm(), 1e-12 * heat_W.norm());
}

TEST(CoolantSteady, reversed_flow_mirrors_the_field) {
  const AffineModel forwards = row_of_lumps(0.008), backwards = row_of_lumps(-0.008);
  const Eigen::VectorXd one_K = solve_steady(forwards, values_of(forwards));
  const Eigen::VectorXd other_K = solve_steady(backwards, values_of(backwards));
  EXPECT_LT((one_K - other_K.reverse()).lpNorm<Eigen::Infinity>(), 1e-10 * 300.0);
  EXPECT_GT(one_K[lumps - 1] - one_K[0], 0.5) << "the liquid warms up on its way";
}

TEST(CoolantSteady, great_flow_is_a_plain_film_and_no_flow_none) {
  AffineModel model = row_of_lumps(1e7);
  AffineModel plain = model;
  plain.boundaries.circuits.clear();
  plain.boundaries.operating.flow_kg_per_s.resize(0);
  EXPECT_LT((solve_steady(model, values_of(model)) - solve_steady(plain, values_of(plain))).lpNorm<Eigen::Infinity>(),
            1e-6);
  model.boundaries.operating.flow_kg_per_s[0] = 0.0;
  for (std::size_t j = 1; j < plain.boundaries.conductances.size(); ++j) {
    plain.boundaries.conductances[j].nominal_W_per_m2K = 0.0;
  }
  EXPECT_LT((solve_steady(model, values_of(model)) - solve_steady(plain, values_of(plain))).lpNorm<Eigen::Infinity>(),
            1e-9);
}

TEST(CoolantTransient, follows_the_matrix_exponential_at_order_two) {
  const AffineModel model = row_of_lumps(0.006);
  const auto [matrix, drive] = dense_system(model, 0.006);
  const Eigen::VectorXd steady_K = matrix.partialPivLu().solve(drive);
  const Eigen::VectorXd start_K = Eigen::VectorXd::LinSpaced(lumps, 300.0, 310.0);
  const double time_s = 64.0;
  const Eigen::MatrixXd rates = matrix / 400.0 * -time_s;
  const Eigen::VectorXd exact_K = steady_K + rates.exp() * (start_K - steady_K);
  double before_K = 0.0;
  for (const double step_s : {0.5, 0.25, 0.125}) {
    FeStepper stepper(model);
    stepper.set_temperatures(start_K);
    stepper.advance(time_s, step_s, values_of(model));
    const double error_K = (stepper.temperatures_K() - exact_K).lpNorm<Eigen::Infinity>();
    if (before_K > 0.0) {
      EXPECT_NEAR(before_K / error_K, 4.0, 0.4);
    }
    before_K = error_K;
  }
  EXPECT_LT(before_K, 1e-4);
  FeStepper exact(model, FeScheme::order_4);
  exact.set_temperatures(start_K);
  exact.advance(time_s, 0.5, values_of(model));
  EXPECT_LT((exact.temperatures_K() - exact_K).lpNorm<Eigen::Infinity>(), 1e-2 * before_K);
}

TEST(CoolantTransient, heat_stored_is_heat_in_less_heat_carried_off) {
  AffineModel model = row_of_lumps(0.006);
  rom::BoundaryValues values = values_of(model);
  FeStepper stepper(model);
  stepper.set_uniform_temperature(300.0);
  double in_J = 0.0, out_J = 0.0, carried_J = 0.0, taken_J = 0.0;
  const double period_s = 0.05;
  const auto outflow = [&] { return heat_balance(model, values, stepper.temperatures_K()).heat_out_W; };
  double before_W = outflow();
  rom::CoolantOutlets before = coolant_outlets(model, values, stepper.temperatures_K());
  for (int k = 0; k < 2000; ++k) {
    if (k == 1000) {  // turned round half-way
      model.boundaries.operating.flow_kg_per_s[0] *= -1.0;
      values = values_of(model);
      before_W = outflow();
      before = coolant_outlets(model, values, stepper.temperatures_K());
    }
    stepper.advance(period_s, period_s, values);
    const double after_W = outflow();
    const rom::CoolantOutlets after = coolant_outlets(model, values, stepper.temperatures_K());
    in_J += period_s * values.heat_W.sum();
    out_J += 0.5 * period_s * (before_W + after_W);
    taken_J += 0.5 * period_s * (before.heat_W[0] + after.heat_W[0]);
    carried_J += 0.5 * period_s * 0.006 * 4180.0 * (before.outlet_K[0] + after.outlet_K[0] - 2.0 * 293.0);
    before_W = after_W;
    before = after;
  }
  const double stored_J = (model.capacity_J_per_K * (stepper.temperatures_K().array() - 300.0).matrix()).sum();
  EXPECT_NEAR(carried_J, taken_J, 1e-9 * taken_J);
  EXPECT_NEAR(in_J - out_J, stored_J, 1e-5 * in_J) << "trapezoids of 0.05 s";
}

}  // namespace solve_coolant_test
}  // namespace spindle_twin::fem_offline

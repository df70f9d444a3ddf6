#include "rom/laws/evaluate.hpp"
#include "rom/laws/motor_loss.hpp"
#include "rom/laws/windage.hpp"
#include "tests/rom/laws/law_checks.hpp"

namespace spindle_twin::rom::test {
namespace laws_losses_test {

WindageShape windage_shape(const ReferenceRow& row) {
  return {row["rotor_radius_m"], row["gap_m"], row["length_m"], 0.025};
}

TEST(Windage, reference_values) {
  for (const ReferenceRow& row : reference_rows("windage")) {
    const WindageShape shape = windage_shape(row);
    const double n = row["speed_rpm"], Re = row["reynolds"], ratio = shape.gap_m / shape.rotor_radius_m;
    expect_close(gap_friction_times_reynolds(LawMode::as_published, ratio, Re) / Re, row["friction_as_published"],
                 "C_f");
    expect_close(gap_friction_times_reynolds(LawMode::standard, ratio, Re) / Re, row["friction_standard"], "C_f");
    expect_close(gap_friction_times_reynolds(LawMode::standard, ratio, 1e-3) / Re, row["friction_couette"], "Couette");
    expect_close(gap_windage_W(LawMode::standard, shape, n, room_K).value, row["standard_W"], "gap");
    expect_close(gap_windage_W(LawMode::as_printed, shape, n, room_K).value, row["as_printed_W"], "as printed");
    expect_close(end_windage_W(LawMode::standard, shape, n, room_K).value, row["ends_W"], "ends");
  }
}

TEST(Windage, printed_heat_is_negative_in_reverse_and_the_others_are_even) {
  const WindageShape shape{0.04, 0.0005, 0.15};
  EXPECT_LT(gap_windage_W(LawMode::as_printed, shape, -6000.0, room_K).value, 0.0);
  for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
    EXPECT_EQ(gap_windage_W(mode, shape, -6000.0, room_K).value, gap_windage_W(mode, shape, 6000.0, room_K).value);
  }
}

TEST(Windage, laminar_gap_is_exact_couette_flow) {
  // Torque between two cylinders, 4π μ L ω r₁² r₂²/(r₂² − r₁²).
  const WindageShape shape{0.04, 0.0005, 0.15};
  const double omega = 10.0 * std::numbers::pi / 30.0, r2 = 0.0405;
  const double mu = air(room_K).viscosity_Pa_s;
  const double torque = 4.0 * std::numbers::pi * mu * 0.15 * omega * 0.0016 * r2 * r2 / (r2 * r2 - 0.0016);
  expect_close(gap_windage_W(LawMode::standard, shape, 10.0, room_K).value, torque * omega, "Couette", 1e-12);
}

TEST(Windage, slopes_and_smoothness_over_speed_and_temperature) {
  const WindageShape shape{0.04, 0.0005, 0.15, 0.02};
  const auto by_speed = [&](const auto& n) {
    using Scalar = std::decay_t<decltype(n)>;
    return gap_windage_W(LawMode::standard, shape, n, Scalar(room_K)).value +
           end_windage_W(LawMode::standard, shape, n, Scalar(room_K)).value;
  };
  const auto by_temperature = [&](const auto& T) {
    using Scalar = std::decay_t<decltype(T)>;
    return gap_windage_W(LawMode::standard, shape, Scalar(9000.0), T).value +
           end_windage_W(LawMode::standard, shape, Scalar(9000.0), T).value;
  };
  expect_slope(by_speed, {-24000.0, -30.0, 0.0, 1.0, 500.0, 900.0, 6000.0, 20000.0, 40000.0}, "windage by speed");
  expect_slope(by_temperature, {150.0, 199.0, 260.0, 300.15, 400.0, 601.0}, "windage by temperature");
  expect_smooth(by_speed, -60000.0, 60000.0, "windage by speed");
  expect_smooth(by_speed, -20.0, 20.0, "windage through standstill");
  expect_smooth(by_temperature, 150.0, 700.0, "windage by temperature");
}

TEST(Windage, published_pieces_jump_where_they_are_said_to) {
  const double ratio = 0.0125;
  const auto step = [&](double at) {
    return gap_friction_times_reynolds(LawMode::as_published, ratio, at * (1 + 1e-12)) /
               gap_friction_times_reynolds(LawMode::as_published, ratio, at * (1 - 1e-12)) -
           1.0;
  };
  EXPECT_NEAR(step(64.0), 0.056, 5e-4);
  EXPECT_NEAR(step(500.0), -0.041, 5e-4);
  EXPECT_NEAR(step(1e4), 0.0002, 1e-4);
  EXPECT_EQ(gap_friction_times_reynolds(LawMode::as_published, ratio, 64.0), std::pow(ratio, 0.3) * std::pow(64.0, 0.4))
      << "5 g/Re is for less than 64";
  const WindageShape disc{0.04, 0.0005, 0.15};
  const double switch_rpm = 3e5 * air(room_K).viscosity_m2_per_s / 0.0016 * 30.0 / std::numbers::pi;
  const auto ends = [&](double n) { return end_windage_W(LawMode::as_published, disc, n, room_K).value; };
  EXPECT_NEAR(ends(switch_rpm * (1 + 1e-12)) / ends(switch_rpm * (1 - 1e-12)) - 1.0, 0.66, 0.005);
}

TEST(Windage, flags_say_what_is_outside) {
  const WindageShape shape{0.04, 0.0005, 0.15};
  EXPECT_EQ(gap_windage_W(LawMode::standard, shape, 6000.0, room_K).flags, in_range);
  EXPECT_TRUE(gap_windage_W(LawMode::standard, shape, 6000.0, 700.0).flags & temperature_clamped);
  EXPECT_TRUE(gap_windage_W(LawMode::standard, shape, 1e8, room_K).flags & above_range);
  EXPECT_TRUE(gap_windage_W(LawMode::standard, {0.04, 0.03, 0.15}, 6000.0, room_K).flags & shape_out_of_range);
}

TEST(Windage, a_rough_rotor_rubs_by_its_factor_more_and_its_ends_as_before) {
  WindageShape shape{0.04, 0.0005, 0.15};
  const double smooth_W = gap_windage_W(LawMode::standard, shape, 6000.0, room_K).value;
  const double ends_W = end_windage_W(LawMode::standard, shape, 6000.0, room_K).value;
  shape.roughness = 2.5;
  expect_close(gap_windage_W(LawMode::standard, shape, 6000.0, room_K).value, 2.5 * smooth_W, "gap", 1e-12);
  EXPECT_EQ(end_windage_W(LawMode::standard, shape, 6000.0, room_K).value, ends_W);
}

TEST(Copper, reference_values) {
  for (const ReferenceRow& row : reference_rows("copper")) {
    CopperLoss copper;
    copper.resistance_20_ohm = row["resistance_20_ohm"];
    const double current_A = row["current_A"], T = row["temperature_C"] + celsius_zero_K;
    expect_close(copper_loss_W(LawMode::standard, copper, current_A, T).value, row["standard_W"], "three phases");
    expect_close(copper_loss_W(LawMode::as_printed, copper, current_A, T).value, row["as_printed_W"], "as printed");
    expect_close(slope(
                     [&](const auto& t) {
                       return copper_loss_W(LawMode::standard, copper, std::decay_t<decltype(t)>(current_A), t).value;
                     },
                     T),
                 row["slope_W_per_K"], "dP/dT");
    copper.ac_ratio = 1.2;
    expect_close(copper_loss_W(LawMode::standard, copper, current_A, T).value, row["standard_ac_1_2_W"], "k_ac 1.2");
    copper.ac_ratio = 1.0;
    copper.phases = 1.0;
    expect_close(copper_loss_W(LawMode::as_published, copper, current_A, T).value, row["one_phase_W"], "one phase");
  }
}

TEST(Copper, printed_formula_holds_the_resistivity_twice) {
  CopperLoss copper;
  copper.resistance_20_ohm = 0.8;
  expect_close(copper_loss_W(LawMode::as_printed, copper, 10.0, room_K).value, 80.0 * 1.724e-8, "as printed");
}

TEST(Copper, resistance_falls_with_temperature_to_a_tenth_and_no_further) {
  CopperLoss copper;
  copper.resistance_20_ohm = 1.0;
  copper.phases = 1.0;
  const auto share_at = [&](double raw) {
    const double T = 293.15 + (raw - 1.0) / copper.temperature_per_K;
    return copper_loss_W(LawMode::standard, copper, 1.0, T).value;
  };
  EXPECT_NEAR(share_at(0.5), 0.5, 1e-12);
  EXPECT_NEAR(share_at(0.2), 0.2, 1e-12) << "the corner begins a tenth above";
  EXPECT_NEAR(share_at(0.1), 0.125, 1e-12) << "its middle: a quarter of the tenth";
  EXPECT_NEAR(share_at(0.05), 0.1 + 0.05 * 0.05 / 0.4, 1e-12);
  EXPECT_NEAR(share_at(-0.5), 0.1, 1e-12);
}

TEST(Copper, slopes_and_smoothness) {
  CopperLoss copper;
  copper.resistance_20_ohm = 0.35;
  copper.ac_ratio = 1.3;
  const auto by_temperature = [&](const auto& T) {
    return copper_loss_W(LawMode::standard, copper, std::decay_t<decltype(T)>(20.0), T).value;
  };
  const auto by_current = [&](const auto& I) {
    return copper_loss_W(LawMode::standard, copper, I, std::decay_t<decltype(I)>(350.0)).value;
  };
  expect_slope(by_temperature, {40.0, 62.0, 80.0, 200.0, 293.15, 400.0}, "copper by temperature");
  expect_slope(by_current, {-10.0, 0.0, 25.0}, "copper by current");
  expect_smooth(by_temperature, 0.0, 600.0, "copper by temperature");
  expect_smooth(by_current, -40.0, 40.0, "copper by current");
  EXPECT_TRUE(copper_loss_W(LawMode::standard, copper, 1.0, 520.0).flags & temperature_clamped);
}

IronLoss reference_iron() {
  IronLoss iron;
  iron.excess = 3e-4;
  iron.relative_permeability = 2000.0;
  return iron;
}

TEST(Iron, reference_values) {
  const IronLoss iron = reference_iron();
  IronLoss rotor = iron;
  rotor.lamination_m = 0.04;
  for (const ReferenceRow& row : reference_rows("iron_W_per_kg")) {
    const double f = row["frequency_Hz"], B = row["flux_T"];
    expect_close(eddy_loss_W_per_kg(LawMode::as_printed, iron, f, B), row["eddy_as_printed"], "printed eddy");
    expect_close(eddy_loss_W_per_kg(LawMode::as_printed, rotor, f, B), row["eddy_as_printed_40_mm"], "rotor thickness");
    expect_close(eddy_loss_W_per_kg(LawMode::as_published, iron, f, B), row["eddy"], "eddy");
    expect_close(eddy_loss_W_per_kg(LawMode::standard, iron, f, B), row["eddy"] * row["skin_factor"], "eddy with skin");
    expect_close(hysteresis_loss_W_per_kg(LawMode::as_printed, iron, f, B), row["hysteresis_as_printed"],
                 "printed hysteresis");
    expect_close(hysteresis_loss_W_per_kg(LawMode::standard, iron, f, B), row["hysteresis_standard"], "hysteresis");
    expect_close(excess_loss_W_per_kg(iron, f, B), row["excess"], "excess");
    expect_close(iron_loss_W(LawMode::standard, iron, f, B).value,
                 row["eddy"] * row["skin_factor"] + row["hysteresis_standard"] + row["excess"], "sum");
  }
}

TEST(Iron, loss_is_that_of_a_kilogram_times_mass_and_build_factor) {
  IronLoss iron = reference_iron();
  const double one_W = iron_loss_W(LawMode::standard, iron, 200.0, 1.1).value;
  iron.mass_kg = 4.0;
  iron.build_factor = 1.6;
  expect_close(iron_loss_W(LawMode::standard, iron, 200.0, 1.1).value, 6.4 * one_W, "4 kg, 1.6", 1e-12);
}

TEST(Iron, a_motor_without_flux_loses_nothing_at_any_speed_and_says_so_with_finite_slopes) {
  IronLaw law = IronLaw::example();
  law.base_flux_T = 0.0;
  LawState state;
  for (const double speed_rpm : {0.0, 300.0, 12000.0}) {
    state[LawInput::speed_rpm] = speed_rpm;
    const LawEvaluation found = evaluate({LawMode::standard, law}, state);
    EXPECT_EQ(found.value, 0.0) << speed_rpm;
    EXPECT_EQ(found.by(LawInput::speed_rpm), 0.0) << speed_rpm;
  }
}

TEST(Iron, skin_factor_goes_from_one_to_three_over_x) {
  EXPECT_EQ(skin_factor(0.0), 1.0);
  EXPECT_NEAR(skin_factor(0.3 - 1e-12), skin_factor(0.3), 1e-12);  // series meets the closed form
  EXPECT_NEAR(skin_factor(40.0 - 1e-12), skin_factor(40.0 + 1e-12), 1e-12);
  EXPECT_NEAR(skin_factor(1e6), 3e-6, 1e-20);
  expect_slope([](const auto& x) { return skin_factor(x); }, {0.05, 0.29, 0.31, 2.0, 10.0, 39.0, 60.0}, "skin factor");
  expect_smooth([](const auto& x) { return skin_factor(x); }, 0.0, 60.0, "skin factor");
}

TEST(Iron, slopes_and_smoothness) {
  const IronLoss iron = reference_iron();
  const auto by_frequency = [&](const auto& f) {
    return iron_loss_W(LawMode::standard, iron, f, std::decay_t<decltype(f)>(1.1)).value;
  };
  const auto by_flux = [&](const auto& B) {
    return iron_loss_W(LawMode::standard, iron, std::decay_t<decltype(B)>(300.0), B).value;
  };
  const auto weakened = [&](const auto& n) {
    const std::decay_t<decltype(n)> f = n / 30.0;
    return iron_loss_W(LawMode::standard, iron, f, core_flux_T(1.2, 6000.0, n)).value;
  };
  expect_slope(by_frequency, {-500.0, -0.05, 0.0, 0.05, 0.1, 50.0, 2000.0}, "iron by frequency");
  expect_slope(by_flux, {0.3, 0.8, 0.9, 1.0, 1.15, 1.2, 1.8}, "iron by flux");
  expect_slope(weakened, {-9000.0, 5500.0, 6000.0, 6500.0, 20000.0}, "iron through base speed");
  expect_smooth(by_frequency, -1000.0, 1000.0, "iron by frequency");
  expect_smooth(by_frequency, -0.3, 0.3, "iron through standstill");
  expect_smooth(by_flux, 0.0, 2.0, "iron by flux");
  expect_smooth(weakened, -30000.0, 30000.0, "iron through base speed");
  EXPECT_TRUE(iron_loss_W(LawMode::standard, iron, 3000.0, 1.0).flags & above_range);
}

}  // namespace laws_losses_test
}  // namespace spindle_twin::rom::test

#include "rom/laws/channel_law.hpp"
#include "rom/laws/coolant_channel.hpp"
#include "tests/rom/laws/law_checks.hpp"

namespace spindle_twin::rom::test {
namespace laws_coolant_test {

constexpr double conductivity = 0.61, prandtl = 5.8;

ChannelShape reference_channel(ChannelFormula formula = ChannelFormula::gnielinski) {
  ChannelShape shape;
  shape.formula = formula;
  shape.hydraulic_diameter_m = 0.008;
  shape.perimeter_m = 0.008 * 3.14159265358979;
  shape.length_m = 3.0;
  return shape;
}

TEST(Fluids, reference_values) {
  for (const ReferenceRow& row : reference_rows("air_at_27_C")) {
    const auto gas = air(room_K);
    expect_close(gas.viscosity_Pa_s, row["viscosity_Pa_s"], "mu");
    expect_close(gas.density_kg_per_m3, row["density_kg_per_m3"], "rho");
    expect_close(gas.viscosity_m2_per_s, row["viscosity_m2_per_s"], "nu");
    expect_close(gas.conductivity_W_per_mK, row["conductivity_W_per_mK"], "k");
  }
  for (const ReferenceRow& row : reference_rows("water_at_27_C")) {
    const auto water = liquid_state(Liquid{}, room_K);
    expect_close(water.viscosity_Pa_s, row["viscosity_Pa_s"], "mu");
    expect_close(water.viscosity_m2_per_s, row["viscosity_m2_per_s"], "nu");
    expect_close(water.conductivity_W_per_mK, row["conductivity_W_per_mK"], "k");
    expect_close(water.prandtl, row["prandtl"], "Pr");
  }
}

TEST(Fluids, slopes_smoothness_and_flags) {
  const auto gas = [](const auto& T) { return air(T).viscosity_m2_per_s * air(T).conductivity_W_per_mK; };
  const auto water = [](const auto& T) {
    return liquid_state(Liquid{}, T).viscosity_Pa_s * liquid_state(Liquid{}, T).prandtl;
  };
  expect_slope(gas, {190.0, 199.0, 201.0, 300.0, 599.0, 620.0}, "air");
  expect_slope(water, {270.0, 275.5, 300.0, 369.5, 380.0}, "water");
  expect_smooth(gas, 150.0, 650.0, "air");
  expect_smooth(water, 250.0, 400.0, "water");
  EXPECT_EQ(liquid_state(Liquid{}, 300.0).flags, in_range);
  EXPECT_EQ(liquid_state(Liquid{}, 272.0).flags, temperature_clamped);
  EXPECT_EQ(air(150.0).flags, temperature_clamped);
}

/// (u + e)²/4e is e/4 at the end itself.
TEST(Fluids, keep_their_laws_up_to_the_rounded_corner_at_the_end_of_their_range) {
  const auto sutherland = [](double T) {
    return 1.716e-5 * std::pow(T / 273.15, 1.5) * (273.15 + 110.4) / (T + 110.4);
  };
  for (const auto& [given_K, held_K] :
       {std::pair{202.0, 202.0}, {200.0, 200.5}, {150.0, 200.0}, {598.0, 598.0}, {600.0, 599.5}}) {
    expect_close(air(given_K).viscosity_Pa_s, sutherland(held_K), "air", 1e-12);
  }
  const Liquid water;
  const auto vogel = [&](double T) { return 2.414e-5 * std::pow(10.0, water.vogel_K / (T - water.vogel_zero_K)); };
  for (const auto& [given_K, held_K] :
       {std::pair{276.0, 276.0}, {275.0, 275.25}, {260.0, 275.0}, {369.0, 369.0}, {370.0, 369.75}}) {
    expect_close(liquid_state(water, given_K).viscosity_Pa_s, vogel(held_K), "water", 1e-12);
  }
  const Lubricant oil = lubricant_through(313.15, 22e-6, 373.15, 4.3e-6);
  const auto viscosity = [&](LawMode mode, double T) { return lubricant_viscosity_m2_per_s(mode, oil, T).value; };
  for (const auto& [given_K, held_K] :
       {std::pair{255.15, 255.15}, {253.15, 253.65}, {423.15, 422.65}, {421.15, 421.15}}) {
    expect_close(viscosity(LawMode::standard, given_K), viscosity(LawMode::as_published, held_K), "oil", 1e-12);
  }
}

TEST(Channel, reference_values) {
  const ChannelShape shape = reference_channel(), trio = reference_channel(ChannelFormula::paper_trio);
  ChannelShape short_one = shape;
  short_one.length_m = 0.008;
  const double ratio = 0.008 / 3.0;
  for (const ReferenceRow& row : reference_rows("channel")) {
    const double Re = row["reynolds"];
    expect_close(printed_channel_film_W_per_m2K(shape, Re, prandtl, conductivity), row["as_printed_W_per_m2K"],
                 "as printed");
    expect_close(printed_channel_film_W_per_m2K(short_one, Re, prandtl, conductivity),
                 row["as_printed_length_is_diameter_W_per_m2K"], "as printed, L = D");
    expect_close(sieder_tate_nusselt(Re * prandtl * ratio), row["sieder_tate"], "Sieder-Tate");
    expect_close(laminar_nusselt(LawMode::standard, 3.66, Re * prandtl * ratio), row["laminar"], "laminar");
    expect_close(laminar_nusselt(LawMode::as_published, 3.66, Re * prandtl * ratio), row["laminar"], "laminar");
    expect_close(hausen_nusselt(Re, prandtl, ratio), row["hausen"], "Hausen");
    expect_close(dittus_boelter_nusselt(Re, prandtl), row["dittus_boelter"], "Dittus-Boelter");
    if (row.has("gnielinski")) expect_close(turbulent_nusselt(Re, prandtl, ratio), row["gnielinski"], "Gnielinski");
    expect_close(channel_nusselt(LawMode::standard, shape, Re, prandtl).value, row["standard"], "standard");
    expect_close(channel_nusselt(LawMode::standard, shape, Re, prandtl).value * conductivity / 0.008,
                 row["standard_W_per_m2K"], "film");
    expect_close(channel_nusselt(LawMode::standard, trio, Re, prandtl).value, row["paper_trio"],
                 "the paper's, put right");
    expect_close(channel_nusselt(LawMode::as_published, shape, Re, prandtl).value, row["as_published"],
                 "Gnielinski 2013");
  }
}

TEST(Channel, printed_formulas_jump_thirteenfold_at_ten_thousand) {
  ChannelShape shape = reference_channel();
  shape.length_m = shape.hydraulic_diameter_m;
  const auto step = [&](double at) {
    return printed_channel_film_W_per_m2K(shape, at, prandtl, conductivity) /
           printed_channel_film_W_per_m2K(shape, at * (1.0 - 1e-9), prandtl, conductivity);
  };
  EXPECT_NEAR(step(1e4), 13.1, 0.05);
  EXPECT_NEAR(step(2200.0) - 1.0, -0.237, 0.001);
}

/// Sieder and Tate's laminar law holds for a Graetz number above 8; above the laminar range it is not asked for.
TEST(Channel, laminar_flow_of_the_papers_three_formulas_has_an_entrance_of_its_own_range) {
  const ChannelShape trio = reference_channel(ChannelFormula::paper_trio);
  const double graetz_per_reynolds = prandtl * trio.hydraulic_diameter_m / trio.length_m;
  const auto flags = [&](double graetz) {
    return channel_nusselt(LawMode::as_published, trio, graetz / graetz_per_reynolds, prandtl).flags;
  };
  EXPECT_EQ(flags(7.9), below_range);
  EXPECT_EQ(flags(8.1), in_range);
  EXPECT_EQ(channel_nusselt(LawMode::as_published, trio, 1e4, 0.5).flags, in_range);
}

TEST(Channel, helix_stays_laminar_longer) {
  for (const ReferenceRow& row : reference_rows("helix")) {
    expect_close(helix_critical_reynolds(row["diameter_over_coil"]), row["critical_reynolds"],
                 "critical Reynolds number");
  }
  ChannelShape helix = reference_channel();
  helix.coil_diameter_m = helix.hydraulic_diameter_m / 0.053;
  const double ratio = 0.008 / 3.0;
  EXPECT_EQ(channel_nusselt(LawMode::standard, helix, 7000.0, prandtl).value,
            laminar_nusselt(LawMode::standard, 3.66, 7000.0 * prandtl * ratio));
  expect_close(channel_nusselt(LawMode::standard, helix, 3e4, prandtl).value,
               turbulent_nusselt(3e4, prandtl, ratio) * (1.0 + 3.6 * (1.0 - 0.053) * std::pow(0.053, 0.8)),
               "turbulent helix");
}

TEST(Channel, rectangular_limit_between_square_and_parallel_plates) {
  EXPECT_NEAR(rectangular_laminar_limit(1.0), 2.98, 0.01);
  EXPECT_NEAR(rectangular_laminar_limit(0.5), 3.39, 0.01);
  EXPECT_EQ(rectangular_laminar_limit(0.0), 7.541);
}

/// Film with the water's own properties over flow, wall and liquid temperature.
TEST(Channel, slopes_and_smoothness) {
  for (const ChannelFormula formula : {ChannelFormula::gnielinski, ChannelFormula::paper_trio}) {
    for (const double coil_m : {0.0, 0.15}) {
      ChannelShape shape = reference_channel(formula);
      shape.coil_diameter_m = coil_m;
      const auto film = [&](const auto& flow, const auto& wall, const auto& liquid) {
        return channel_film_W_per_m2K(LawMode::standard, shape, Liquid{}, flow, wall, liquid).value;
      };
      const auto by_flow = [&](const auto& flow) {
        using Scalar = std::decay_t<decltype(flow)>;
        return film(flow, Scalar(305.0), Scalar(room_K));
      };
      const auto by_wall = [&](const auto& wall) {
        using Scalar = std::decay_t<decltype(wall)>;
        return film(Scalar(0.03), wall, Scalar(room_K));
      };
      const auto by_liquid = [&](const auto& liquid) {
        using Scalar = std::decay_t<decltype(liquid)>;
        return film(Scalar(0.015), Scalar(305.0), liquid);
      };
      expect_slope(by_flow, {-0.05, -1e-4, 0.0, 1e-5, 5e-4, 0.01, 0.0125, 0.015, 0.02, 0.05, 0.12, 0.4},
                   "film by flow");
      expect_slope(by_wall, {270.0, 290.0, 310.0, 372.0}, "film by wall");
      expect_slope(by_liquid, {270.0, 290.0, 310.0, 350.0}, "film by liquid");
      expect_smooth(by_flow, -0.2, 0.2, "film by flow");
      expect_smooth(by_flow, -2e-3, 2e-3, "film through zero flow");
      expect_smooth(by_wall, 260.0, 390.0, "film by wall");
      expect_smooth(by_liquid, 260.0, 390.0, "film by liquid");
    }
  }
}

TEST(Channel, still_water_keeps_the_laminar_limit) {
  const double film =
      channel_film_W_per_m2K(LawMode::standard, reference_channel(), Liquid{}, 0.0, room_K, room_K).value;
  expect_close(film, 3.66 * liquid_state(Liquid{}, room_K).conductivity_W_per_mK / 0.008, "no flow");
}

TEST(Channel, published_transition_has_a_corner_of_slope) {
  const auto law = [](const auto& Re) {
    return channel_nusselt(LawMode::as_published, reference_channel(), Re, std::decay_t<decltype(Re)>(prandtl)).value;
  };
  const Jumps jumps = scan(law, 1000.0, 6000.0);
  EXPECT_LT(jumps.value, 1e-6);
  EXPECT_GT(jumps.slope, 0.1);  // what the scan is there to find
}

TEST(Channel, a_liquid_is_a_law_over_two_kelvin_at_least_above_its_vogel_temperature) {
  ChannelLaw law = ChannelLaw::example();
  EXPECT_EQ(law.fault(), "");
  const double coldest_K = law.liquid.coldest_K;
  law.liquid.hottest_K = coldest_K + 2.01;
  EXPECT_EQ(law.fault(), "");
  for (const double width_K : {1.99, 0.0, -1.99}) {
    law.liquid.hottest_K = coldest_K + width_K;
    EXPECT_NE(law.fault(), "") << width_K;
  }
  law = ChannelLaw::example();
  law.liquid.vogel_zero_K = coldest_K;
  EXPECT_NE(law.fault(), "");
}

TEST(ChannelLaw, heat_up_reference_values) {
  for (const ReferenceRow& row : reference_rows("coolant_heat_up_200_W_per_K")) {
    const double flow_W_per_K = row["flow_kg_per_s"] * 4179.0;
    expect_close(200.0 / flow_W_per_K, row["ntu"], "NTU");
    expect_close(channel_W_per_m2K(500.0, 0.4, flow_W_per_K) * 0.4, row["effective_W_per_K"], "G");
    expect_close(100.0 / flow_W_per_K, row["outlet_rise_per_100_W_K"], "outlet");
  }
}

TEST(ChannelLaw, slopes_and_smoothness) {
  const auto by_flow = [](const auto& W) { return channel_W_per_m2K(std::decay_t<decltype(W)>(500.0), 0.4, W); };
  const auto by_film = [](const auto& h) { return channel_W_per_m2K(h, 0.4, std::decay_t<decltype(h)>(69.4)); };
  expect_slope(by_flow, {1e-6, 0.2, 0.3, 5.0, 200.0, 1e5}, "G by flow");
  expect_slope(by_film, {1e-3, 100.0, 1e5}, "G by film");
  expect_smooth(by_flow, 0.0, 10.0, "G by flow");
  expect_smooth(by_flow, 0.0, 2000.0, "G by flow");
  expect_smooth(by_film, 0.0, 2e4, "G by film");
  EXPECT_EQ(slope(by_flow, 0.0), 1.0 / 0.4);  // all that the liquid can carry
}

}  // namespace laws_coolant_test
}  // namespace spindle_twin::rom::test

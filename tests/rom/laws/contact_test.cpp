#include "correction/paper/joint_law.hpp"
#include "rom/laws/contact_conductance.hpp"
#include "rom/laws/interference_fit.hpp"
#include "tests/rom/laws/law_checks.hpp"

namespace spindle_twin::rom::test {
namespace laws_contact_test {

/// Ground steel 45 on GCr15.
ContactSurfaces reference_surfaces() {
  ContactSurfaces surfaces;
  surfaces.conductivity_W_per_mK = harmonic_mean(48.0, 44.0);
  surfaces.roughness_m = 0.8e-6 * std::sqrt(2.0);
  surfaces.slope = 0.1 * std::sqrt(2.0);
  surfaces.young_Pa = 1.0 / ((1.0 - 0.269 * 0.269) / 209e9 + (1.0 - 0.3 * 0.3) / 219e9);
  surfaces.gas_jump_m = gas_jump_m(0.9, 0.9, 1.4, 0.7, 68e-9);
  return surfaces;
}

/// GCr15 ring in a sleeve of steel 45, 4 µm.
InterferenceFit reference_fit() { return {0.037, 0.04, 0.05, 219e9, 0.3, 1.2e-5, 209e9, 0.269, 1.17e-5, 4e-6}; }

TEST(Contact, reference_values) {
  for (const ReferenceRow& row : reference_rows("contact_surfaces")) {
    const ContactSurfaces surfaces = reference_surfaces();
    expect_close(surfaces.conductivity_W_per_mK, row["conductivity_W_per_mK"], "k");
    expect_close(surfaces.roughness_m, row["roughness_m"], "sigma");
    expect_close(surfaces.slope, row["slope"], "m");
    expect_close(surfaces.young_Pa, row["young_Pa"], "E'");
    expect_close(surfaces.gas_jump_m, row["air_jump_m"], "M");
  }
  for (const ReferenceRow& row : reference_rows("contact")) {
    ContactSurfaces air_filled = reference_surfaces(), oil_filled = air_filled, elastic = air_filled;
    oil_filled.gap_conductivity_W_per_mK = 0.13;
    oil_filled.gas_jump_m = 0.0;
    elastic.formula = ContactFormula::elastic;
    const double P = row["pressure_Pa"];
    expect_close(spot_conductance_W_per_m2K(air_filled, P), row["plastic_W_per_m2K"], "plastic");
    expect_close(spot_conductance_W_per_m2K(elastic, P), row["elastic_W_per_m2K"], "elastic");
    expect_close(plane_distance_m(air_filled, P), row["plane_distance_m"], "Y");
    expect_close(gap_conductance_W_per_m2K(air_filled, P, 0.0), row["gap_air_W_per_m2K"], "air");
    expect_close(gap_conductance_W_per_m2K(oil_filled, P, 0.0), row["gap_oil_W_per_m2K"], "oil");
    for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
      const auto law = [&](const auto& pressure) {
        return contact_conductance_W_per_m2K(mode, air_filled, pressure, std::decay_t<decltype(pressure)>(0.0)).value;
      };
      expect_close(law(P), row["joint_W_per_m2K"], "joint");
      expect_close(1.0 / law(P), row["joint_m2K_per_W"], "joint");
      expect_close(slope(law, P), row["slope_W_per_m2KPa"], "dh/dP");
      expect_close(slope(law, P) * P / law(P), row["log_slope"], "exponent");
    }
  }
}

TEST(Contact, paper_formula_reference_values) {
  for (const ReferenceRow& row : reference_rows("paper_contact")) {
    ContactSurfaces surfaces;
    surfaces.formula = ContactFormula::paper;
    surfaces.conductivity_W_per_mK = row["conductivity_W_per_mK"];
    surfaces.roughness_m = row["roughness_um"] * 1e-6;
    surfaces.young_Pa = row["young_GPa"] * 1e9;
    const double P = row["pressure_MPa"] * 1e6;
    expect_close(1.0 / contact_conductance_W_per_m2K(LawMode::as_printed, surfaces, P, 0.0).value,
                 row["resistance_as_printed"], "as printed");
    expect_close(1.0 / contact_conductance_W_per_m2K(LawMode::as_published, surfaces, P, 0.0).value,
                 row["resistance_m2K_per_W"], "SI");
    expect_close(contact_conductance_W_per_m2K(LawMode::standard, surfaces, P, 0.0).value, row["conductance_W_per_m2K"],
                 "SI");
  }
}

TEST(Contact, slopes_and_smoothness_down_to_no_pressure_and_into_an_open_gap) {
  for (const ContactFormula formula : {ContactFormula::plastic, ContactFormula::elastic, ContactFormula::paper}) {
    ContactSurfaces surfaces = reference_surfaces();
    surfaces.formula = formula;
    const auto by_pressure = [&](const auto& P) {
      return contact_conductance_W_per_m2K(LawMode::standard, surfaces, P, std::decay_t<decltype(P)>(0.0)).value;
    };
    expect_slope(by_pressure, {-1e5, 0.0, 1e3, 3e3, 6.1e3, 1e5, 1e7}, "contact by pressure");
    expect_smooth(by_pressure, -1e4, 2e4, "contact through zero pressure");
    expect_smooth(by_pressure, -1e7, 6e7, "contact by pressure");
    EXPECT_GT(by_pressure(-1e9), 0.0);
  }
  const auto by_gap = [](const auto& c) {
    return contact_conductance_W_per_m2K(LawMode::standard, reference_surfaces(), std::decay_t<decltype(c)>(0.0), c)
        .value;
  };
  expect_slope(by_gap, {0.0, 1e-7, 5e-5}, "contact by clearance");
  EXPECT_EQ(contact_conductance_W_per_m2K(LawMode::as_published, reference_surfaces(), 0.0, 0.0).value, 0.0);
  EXPECT_TRUE(contact_conductance_W_per_m2K(LawMode::standard, reference_surfaces(), 1e8, 0.0).flags & above_range);
  EXPECT_TRUE(contact_conductance_W_per_m2K(LawMode::standard, reference_surfaces(), 0.0, 1e-6).flags & joint_open);
}

TEST(InterferenceFit, reference_values) {
  for (const ReferenceRow& row : reference_rows("interference_fit")) {
    const InterferenceFit fit = reference_fit();
    EXPECT_EQ(fit.joint_radius_m, row["joint_radius_m"]);
    expect_close(fit_stiffness_Pa_per_m(fit) * 1e-12, row["stiffness_MPa_per_um"], "stiffness");
    for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
      expect_close(fit_state(mode, fit, 0.0, 0.0, 0.0).pressure_Pa, row["pressure_at_4_um_Pa"], "4 µm");
    }
  }
}

TEST(InterferenceFit, warm_ring_presses_harder_and_conducts_better) {
  const InterferenceFit fit = reference_fit();
  const ContactSurfaces surfaces = reference_surfaces();
  const double assembly_Pa = fit_state(LawMode::standard, fit, 0.0, 0.0, 0.0).pressure_Pa;
  const auto conductance = [&](double P) {
    return contact_conductance_W_per_m2K(LawMode::standard, surfaces, P, 0.0).value;
  };
  const JointFit joint{assembly_Pa, fit_stiffness_Pa_per_m(fit) * 0.04 * 1.2e-5,
                       fit_stiffness_Pa_per_m(fit) * 0.04 * 1.17e-5};
  for (const ReferenceRow& row : reference_rows("fit_resistance_ratio")) {
    const double rise_K = row["inner_rise_K"];
    const double P = fit_state(LawMode::standard, fit, rise_K, 0.0, 0.0).pressure_Pa;
    expect_close(P * 1e-6, row["pressure_MPa"], "p");
    for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
      expect_close(pressure_resistance_ratio(mode, P, assembly_Pa).value, row["power_law"], "R'/R");
    }
    expect_close(correction::joint_resistance_ratio(joint, rise_K, 0.0, 0.68, 0.1, 10.0), row["power_law"],
                 "the paper's correction");
    expect_close(conductance(assembly_Pa) / conductance(P), row["contact_law"], "R'/R");
  }
}

TEST(InterferenceFit, printed_correction_has_a_pole_at_zero_and_only_ever_grows) {
  for (const ReferenceRow& row : reference_rows("paper_resistance_ratio")) {
    const double rise_K = row["rise_difference_K"];
    const double found = printed_resistance_ratio(rise_K, 1e6, 209e9, 0.01, 1.17e-5).value;
    expect_close(found, row["ratio_SI"], "SI");
    expect_close(printed_resistance_ratio(rise_K, 1.0, 209.0, 0.01, 1.17e-5).value, row["ratio_MPa_GPa"], "MPa, GPa");
    EXPECT_GT(found, 1.0);
  }
  EXPECT_GT(printed_resistance_ratio(1e-12, 1e6, 209e9, 0.01, 1.17e-5).value, 1e9);
  for (const double rise_K : {0.0, -1.0}) {
    EXPECT_EQ(printed_resistance_ratio(rise_K, 1e6, 209e9, 0.01, 1.17e-5).flags, undefined);
    EXPECT_EQ(printed_resistance_ratio(rise_K, 1e6, 209e9, 0.01, 1.17e-5).value, 1.0);
  }
  expect_slope([](const auto& t) { return printed_resistance_ratio(t, 1e6, 209e9, 0.01, 1.17e-5).value; }, {0.2, 5.0},
               "printed");
}

TEST(InterferenceFit, slopes_and_smoothness_through_opening) {
  InterferenceFit fit = reference_fit();
  fit.centrifugal_m_s2 = 1e-12;
  const ContactSurfaces surfaces = reference_surfaces();
  const auto joint = [&](const auto& inner, const auto& outer, const auto& omega) {
    using Scalar = std::decay_t<decltype(inner)>;
    const auto state = fit_state(LawMode::standard, fit, inner, Scalar(outer), Scalar(omega));
    return contact_conductance_W_per_m2K(LawMode::standard, surfaces, state.pressure_Pa, state.gap_m).value;
  };
  const auto by_inner = [&](const auto& T) { return joint(T, 0.0, 0.0); };
  const auto by_outer = [&](const auto& T) {
    using Scalar = std::decay_t<decltype(T)>;
    return joint(Scalar(0.0), T, 0.0);
  };
  const auto by_speed = [&](const auto& omega) {
    using Scalar = std::decay_t<decltype(omega)>;
    return joint(Scalar(0.0), 0.0, omega);
  };
  expect_slope(by_inner, {-30.0, -8.4, -8.33, -8.3, -5.0, 0.0, 20.0}, "joint by inner rise");
  expect_slope(by_outer, {-20.0, 0.0, 8.5, 30.0}, "joint by outer rise");
  expect_slope(by_speed, {-1000.0, 0.0, 1995.0, 2100.0}, "joint by speed");
  expect_smooth(by_inner, -40.0, 40.0, "joint by inner rise");
  expect_smooth(by_inner, -8.8, -7.8, "joint through opening");
  expect_smooth(by_outer, -40.0, 40.0, "joint by outer rise");
  expect_smooth(by_speed, -3000.0, 3000.0, "joint by speed");
  EXPECT_TRUE(fit_state(LawMode::standard, fit, -20.0, 0.0, 0.0).flags & joint_open);
  const auto ratio = [&](const auto& P) { return pressure_resistance_ratio(LawMode::standard, P, 1.24e6).value; };
  expect_slope(ratio, {1e3, 4.2e4, 1e6, 3e7, 4e7}, "resistance ratio");
  expect_smooth(ratio, -1e5, 1e6, "resistance ratio");
  expect_smooth(ratio, 1e6, 1e8, "resistance ratio");
}

/// Slope of the joint's resistance by the inner body's temperature: −(1/h²)(dh/dp) (dp/dd) b a.
TEST(InterferenceFit, slope_of_the_resistance_is_the_product_of_its_links) {
  const InterferenceFit fit = reference_fit();
  const ContactSurfaces surfaces = reference_surfaces();
  const auto conductance = [&](const auto& P) {
    return contact_conductance_W_per_m2K(LawMode::standard, surfaces, P, std::decay_t<decltype(P)>(0.0)).value;
  };
  const auto resistance = [&](const auto& T) {
    using Scalar = std::decay_t<decltype(T)>;
    return 1.0 / conductance(fit_state(LawMode::standard, fit, T, Scalar(0.0), Scalar(0.0)).pressure_Pa);
  };
  const double P = fit_state(LawMode::standard, fit, 5.0, 0.0, 0.0).pressure_Pa, h = conductance(P);
  expect_close(slope(resistance, 5.0), -slope(conductance, P) / (h * h) * fit_stiffness_Pa_per_m(fit) * 0.04 * 1.2e-5,
               "dR/dT");
}

}  // namespace laws_contact_test
}  // namespace spindle_twin::rom::test

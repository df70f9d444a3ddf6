#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rom/boundary_values/schedule.hpp"
#include "rom/file/payload.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/signature.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/heat_flows.hpp"
#include "rom/integrate/law_terms.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/network.hpp"
#include "rom/option.hpp"
#include "rom/range.hpp"
#include "rom/read_laws/read_physical_law.hpp"
#include "rom/units.hpp"
#include "tests/rom/synthetic_network.hpp"

/// What nobody has set says nothing: no error was measured, no index names anything, a law multiplies by one.
namespace spindle_twin::rom::tests {
namespace defaults_test {

void expect_all_zero(const CertificateErrors& errors) {
  EXPECT_EQ(errors.key_points_K, 0.0);
  EXPECT_EQ(errors.nose_um, 0.0);
  EXPECT_EQ(errors.part_max_K, 0.0);
}

TEST(Defaults, a_certificate_that_nobody_measured_has_no_case_no_error_and_no_box) {
  const Certificate none;
  EXPECT_EQ(none.seed, 0U);
  EXPECT_EQ(none.cases, 0U);
  EXPECT_EQ(none.searched, 0U);
  EXPECT_EQ(none.fe_unknowns, 0U);
  EXPECT_EQ(none.mesh_size_m, 0.0);
  for (const CertificateErrors& errors : {none.worst, none.median, none.limit, none.worst_found}) {
    expect_all_zero(errors);
  }
  EXPECT_EQ(none.limit_rule.content, 0.0);
  EXPECT_EQ(none.limit_rule.confidence, 0.0);
  EXPECT_FALSE(none.limit_rule.fitted);
  EXPECT_EQ(none.box.contact_low, 0.0);
  EXPECT_EQ(none.box.contact_high, 0.0);
  EXPECT_EQ(none.box.film_low, 0.0);
  EXPECT_EQ(none.box.film_high, 0.0);
  EXPECT_EQ(none.box.speed_high_rpm, 0.0);
}

TEST(Defaults, errors_of_an_output_that_nobody_measured_are_zero_and_those_not_given_stay_so) {
  const OutputError none;
  EXPECT_EQ(none.worst, 0.0);
  EXPECT_EQ(none.median, 0.0);
  EXPECT_EQ(none.mesh, 0.0);
  EXPECT_EQ(none.limit, 0.0);
  const OutputError as_files_before_limits{3.0, 2.0, 1.0};
  EXPECT_EQ(as_files_before_limits.limit, 0.0);
}

TEST(Defaults, nodes_and_points_stand_at_the_origin_and_a_network_is_not_hand_written) {
  const Node node;
  EXPECT_EQ(node.r_m, 0.0);
  EXPECT_EQ(node.z_m, 0.0);
  const KeyPoint point;
  EXPECT_EQ(point.r_m, 0.0);
  EXPECT_EQ(point.z_m, 0.0);
  EXPECT_EQ(ContactPressureOutput{}.assembly_pressure_Pa, 0.0);
  EXPECT_FALSE(Network{}.hand_written);
}

TEST(Defaults, an_exchange_is_between_no_bodies_and_multiplies_by_one) {
  const Conductance conductance;
  EXPECT_EQ(conductance.kind, ConductanceKind::contact);
  EXPECT_EQ(conductance.nominal_W_per_m2K, 0.0);
  EXPECT_EQ(conductance.area_m2, 0.0);
  EXPECT_EQ(conductance.environment, -1);
  EXPECT_EQ(conductance.part_a, -1);
  EXPECT_EQ(conductance.part_b, -1);
  for (const double speed_rpm : {0.0, 500.0, -8000.0}) {
    EXPECT_EQ(evaluate_speed_law(conductance.law, speed_rpm, 1000.0, 0.3), 1.0);
  }
  const JointFit fit;
  EXPECT_EQ(fit.assembly_pressure_Pa, 0.0);
  EXPECT_EQ(fit.pressure_per_inner_rise_Pa_per_K, 0.0);
  EXPECT_EQ(fit.pressure_per_outer_rise_Pa_per_K, 0.0);
}

TEST(Defaults, a_heat_is_neither_measured_nor_friction_and_a_power_term_adds_nothing) {
  const HeatSource heat;
  EXPECT_EQ(heat.nominal_W, 0.0);
  EXPECT_FALSE(heat.measured);
  EXPECT_FALSE(heat.friction);
  EXPECT_EQ(PowerTerm{}.coefficient, 0.0);
  EXPECT_EQ(PowerTerm{}.exponent, 0.0);
  EXPECT_EQ(Environment{}.kind, EnvironmentKind::ambient);
}

TEST(Defaults, a_law_that_names_nothing_reads_nothing_of_the_network) {
  const BoundLaw law;
  for (const LawTemperature& temperature : {law.first, law.second}) {
    EXPECT_EQ(temperature.part, -1);
    EXPECT_EQ(temperature.environment, -1);
    EXPECT_EQ(temperature.nominal_K, 20.0 + zero_degC_K);
  }
  EXPECT_EQ(law.pressure, -1);
  EXPECT_EQ(law.displacement, -1);
  EXPECT_EQ(law.displacement_sign, 1.0);
  EXPECT_EQ(law.nominal_pressure_Pa, 0.0);
  EXPECT_EQ(law.nominal_displacement_m, 0.0);
  EXPECT_EQ(law.circuit, -1);
  EXPECT_EQ(CoolantCircuit{}.environment, -1);
  const LawDefaults places;
  EXPECT_EQ(places.first_part, -1);
  EXPECT_EQ(places.second_environment, -1);
  EXPECT_EQ(places.circuit, -1);
  const LawTerm term;
  EXPECT_EQ(term.source, -1);
  EXPECT_EQ(term.conductance, -1);
  EXPECT_EQ(term.environment, -1);
  EXPECT_EQ(term.segment, -1);
  EXPECT_EQ(term.circuit, -1);
}

TEST(Defaults, a_machine_of_which_nothing_is_known_stands_still_and_reads_nothing) {
  const OperatingState state;
  EXPECT_EQ(state.speed_rpm, 0.0);
  EXPECT_EQ(state.load, 0.0);
  EXPECT_FALSE(state.current_A.has_value());
  EXPECT_FALSE(state.power_W.has_value());
  const LawDrive drive;
  EXPECT_FALSE(drive.follow) << "laws are held unless somebody says otherwise";
  EXPECT_EQ(drive.speed_rpm, 0.0);
  EXPECT_EQ(drive.load, 0.0);
  const LawState law_state;
  EXPECT_EQ(law_state.load, 0.0);
  for (const double input : law_state.inputs) EXPECT_EQ(input, 0.0);
  const LawEvaluation nothing;
  EXPECT_EQ(nothing.value, 0.0);
  for (const double slope : nothing.slope) EXPECT_EQ(slope, 0.0);
  const Boundaries boundaries;
  EXPECT_EQ(boundaries.reference_speed_rpm, 0.0);
  EXPECT_EQ(boundaries.reference_temperature_K, 0.0);
  EXPECT_EQ(CorrectionFactors{}.expansion, 1.0);
  const ScheduleRow row;
  EXPECT_EQ(row.time_s, 0.0);
  EXPECT_EQ(row.line, 0);
}

TEST(Defaults, an_option_takes_any_number_has_no_zero_of_its_own_and_writes_zero_as_zero) {
  const Option option{"key", "doc"};
  EXPECT_EQ(option.range.min, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(option.range.max, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(option.or_zero);
  EXPECT_EQ(option.written_as_0, 0.0);
  const Option deviation = zero_or_some("deviation_K", "doc", 5.0);
  EXPECT_TRUE(deviation.or_zero);
  EXPECT_TRUE(is_allowed(deviation.range, 0.0));
  EXPECT_TRUE(is_allowed(deviation.range, 5.0));
  EXPECT_FALSE(is_allowed(deviation.range, -1e-12));
  EXPECT_EQ(least_but_zero, 1e-9);
}

TEST(Defaults, a_path_has_no_place_and_an_integrator_has_done_nothing) {
  const FlowPath path;
  EXPECT_EQ(path.conductance, 0);
  EXPECT_FALSE(path.has_place);
  EXPECT_EQ(path.r_m, 0.0);
  EXPECT_EQ(path.z_m, 0.0);
  const CvodeCounts counts;
  EXPECT_EQ(counts.internal_steps, 0);
  EXPECT_EQ(counts.right_hand_sides, 0);
  EXPECT_EQ(counts.decompositions, 0);
  EXPECT_EQ(counts.restarts, 0);
}

TEST(Defaults, outputs_grow_by_the_networks_own_expansion_unless_another_is_given) {
  const Network network = make_single_node();
  NetworkOutputs outputs = make_network_outputs(network);
  const Eigen::VectorXd warm_K = Eigen::VectorXd::Constant(1, 310.0);
  evaluate_outputs(network, warm_K, outputs);
  EXPECT_NEAR(outputs.deformations_m[0], 2e-6 * 10.0, 1e-18);
  evaluate_outputs(network, warm_K, outputs, 1.5);
  EXPECT_NEAR(outputs.deformations_m[0], 3e-6 * 10.0, 1e-18);
}

/// Numbers that stand in READMEs and in files that others read; they change with a new version of the file only.
TEST(Defaults, files_keep_their_versions_sizes_and_units) {
  EXPECT_EQ(rom_format_version, 1U);
  EXPECT_EQ(rom_format_version_signed, 2U);
  EXPECT_EQ(rom_largest_file_bytes, 64U * 1024U * 1024U) << "64 MiB";
  EXPECT_EQ(signature_block_size, 8U + 32U + 64U) << "magic, key, signature";
  EXPECT_EQ(RomFile{}.schema_version, 0U);
  EXPECT_EQ(DecodedPayload{}.schema_version, 0U);
  EXPECT_EQ(most_nodes, 2000U);
  EXPECT_EQ(most_items, 10000U);
  EXPECT_EQ(um_per_m * m_per_um, 1.0);
  EXPECT_EQ(um_per_m, 1e6);
  EXPECT_EQ(seconds_per_hour, 60.0 * seconds_per_minute);
  EXPECT_EQ(seconds_per_minute, 60.0);
}

}  // namespace defaults_test
}  // namespace spindle_twin::rom::tests

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "rom/boundary_values/held_law.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/integrate/output_uncertainty.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::rom::tests {
namespace old_files_test {

const std::string old_files = SPINDLE_TWIN_SOURCE_DIR "/tests/rom/old_files/";

/// A file without errors per output: the worst of each kind stands for every output of the kind.
void expect_old_certificate(const Network& network) {
  EXPECT_FALSE(network.hand_written);
  EXPECT_TRUE(network.certificate.key_points_K.empty());
  EXPECT_TRUE(network.certificate.deformations_m.empty());
  EXPECT_EQ(network.certificate.fe_unknowns, 0u);
  const OutputUncertainty sigma = output_uncertainty(network);
  EXPECT_EQ(sigma.key_points_K[1], network.certificate.worst.key_points_K / 2.0);
  EXPECT_EQ(sigma.part_maxima_K[0], network.certificate.worst.part_max_K / 2.0);
  EXPECT_NEAR(sigma.deformations_m[0], 0.5e-6 * network.certificate.worst.nose_um, 1e-18);
  EXPECT_EQ(sigma.part_means_K[0], network.certificate.worst.part_max_K / 2.0);
}

TEST(OldFiles, version_1_keeps_its_meaning) {
  const RomFile file = read_rom_file(old_files + "schema_1.rom");
  EXPECT_EQ(file.schema_version, 1u);
  EXPECT_FALSE(file.signed_by);
  const Network& network = file.network;
  EXPECT_EQ(network.spindle, "belt_driven");
  EXPECT_EQ(network.nodes.size(), 4u);
  EXPECT_EQ(network.parts.size(), 13u);
  EXPECT_NEAR(network.capacity_J_per_K.sum(), 11444.0, 0.5);
  ASSERT_EQ(network.boundaries.conductances.size(), 21u);
  EXPECT_EQ(network.boundaries.conductances[3].name, "front_outer_ring/housing");
  EXPECT_EQ(network.boundaries.conductances[3].nominal_W_per_m2K, 4000.0);
  EXPECT_TRUE(network.boundaries.circuits.empty());
  EXPECT_EQ(network.boundaries.sources[2].name, "belt");
  EXPECT_EQ(network.boundaries.sources[2].nominal_W, 25.0);
  EXPECT_EQ(network.contact_pressures.size(), 2u);
  EXPECT_NEAR(1e6 * network.deformations[1].row_m_per_K.sum(), 0.5210, 5e-5);
  EXPECT_EQ(network.certificate.cases, 2u);
  EXPECT_NEAR(network.certificate.worst.key_points_K, 9.2607, 5e-5);
  EXPECT_NEAR(network.certificate.median.nose_um, 22.3119, 5e-5);
  expect_old_certificate(network);
}

TEST(OldFiles, version_2_keeps_its_circuit_and_its_certificate) {
  const RomFile file = read_rom_file(old_files + "schema_2.rom");
  EXPECT_EQ(file.schema_version, 2u);
  const Network& network = file.network;
  EXPECT_EQ(network.nodes.size(), 6u);
  ASSERT_EQ(network.boundaries.circuits.size(), 1u);
  EXPECT_EQ(network.boundaries.circuits[0].name, "helix");
  EXPECT_EQ(network.boundaries.circuits[0].segments, (std::vector<int>{2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(network.boundaries.circuits[0].heat_capacity_J_per_kgK, 4180.0);
  EXPECT_EQ(network.boundaries.operating.flow_kg_per_s[0], 0.02);
  EXPECT_NEAR(network.certificate.worst.nose_um, 6.4203, 5e-5);
  expect_old_certificate(network);
}

TEST(OldFiles, version_3_keeps_its_errors_per_output_and_has_no_laws) {
  const RomFile file = read_rom_file(old_files + "schema_3.rom");
  EXPECT_EQ(file.schema_version, 3u);
  const Network& network = file.network;
  EXPECT_EQ(network.spindle, "jacket_circuit");
  ASSERT_EQ(network.boundaries.circuits.size(), 1u);
  EXPECT_EQ(network.certificate.cases, 2u);
  EXPECT_EQ(network.certificate.deformations_m.size(), network.deformations.size());
  EXPECT_EQ(network.certificate.key_points_K.size(), network.key_points.size());
  EXPECT_FALSE(has_physics(network.boundaries));
  EXPECT_GT(network.boundaries.sources[0].nominal_W, 0.0);
}

TEST(OldFiles, version_3_by_hand_is_what_the_example_still_says) {
  const RomFile file = read_rom_file(old_files + "schema_3_hand.rom");
  EXPECT_EQ(file.schema_version, 3u);
  EXPECT_TRUE(file.network.hand_written);
  const Network now = read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle.toml");
  EXPECT_EQ(encode_network(file.network), encode_network(now));
}

TEST(OldFiles, version_4_by_hand_keeps_its_laws_and_measures_no_heat) {
  const RomFile file = read_rom_file(old_files + "schema_4_hand.rom");
  EXPECT_EQ(file.schema_version, 4u);
  EXPECT_TRUE(has_physics(file.network.boundaries));
  EXPECT_TRUE(measured_heats(file.network.boundaries).empty());
  EXPECT_EQ(file.network.boundaries.operating.heat_W.size(), 0);
  const Network now = read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle_laws.toml");
  EXPECT_EQ(encode_network(file.network), encode_network(now));
  EXPECT_EQ(read_rom_file(old_files + "schema_4.rom").network.certificate.cases, 2u);
}

TEST(OldFiles, version_5_has_no_limits_and_the_worst_case_stands_for_them) {
  const RomFile file = read_rom_file(old_files + "schema_5.rom");
  EXPECT_EQ(file.schema_version, 5u);
  const Certificate& certificate = file.network.certificate;
  EXPECT_EQ(certificate.cases, 2u);
  EXPECT_EQ(certificate.limit_rule.content, 0.0);
  ASSERT_EQ(certificate.deformations_m.size(), file.network.deformations.size());
  const OutputError& nose = certificate.deformations_m.front();
  EXPECT_GT(nose.worst, 0.0);
  EXPECT_EQ(nose.limit, 0.0);
  EXPECT_EQ(output_uncertainty(file.network).deformations_m[0], std::hypot(0.5 * nose.worst, nose.mesh));
  const Network now = read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle_laws.toml");
  EXPECT_EQ(encode_network(read_rom_file(old_files + "schema_5_hand.rom").network), encode_network(now));
}

/// Bit for bit what the program of that time was given, which this one still holds in its sources.
TEST(OldFiles, version_1_without_a_certificate_is_read_bit_for_bit) {
  const RomFile file = read_rom_file(old_files + "schema_1_uncertified.rom");
  EXPECT_EQ(file.schema_version, 1u);
  EXPECT_EQ(file.network.certificate.cases, 0u);
  EXPECT_TRUE(std::isnan(output_uncertainty(file.network).key_points_K[0]));
  Network now = spindle_twin::tests::small_network();
  now.certificate = {};
  EXPECT_EQ(encode_network(file.network), encode_network(now));
}

/// Reading and writing again makes a file of today's version with the same content.
TEST(OldFiles, written_again_they_are_of_this_version) {
  for (const char* name :
       {"schema_1.rom", "schema_2.rom", "schema_1_uncertified.rom", "schema_3.rom", "schema_3_hand.rom", "schema_4.rom",
        "schema_4_hand.rom", "schema_5.rom", "schema_5_hand.rom"}) {
    SCOPED_TRACE(name);
    const std::vector<std::uint8_t> once = encode_network(read_network(old_files + name));
    const RomFile again = decode_rom_file(once, "again.rom");
    EXPECT_EQ(again.schema_version, 6u);
    EXPECT_EQ(encode_network(again.network), once);
  }
}

}  // namespace old_files_test
}  // namespace spindle_twin::rom::tests

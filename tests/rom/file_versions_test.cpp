#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "rom/file/file_header.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/signature.hpp"
#include "rom/read/sha256.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/rom/synthetic_network.hpp"
#include "tests/support/texts.hpp"
#include "tests/support/wire_faults.hpp"

/// A network file says nothing that its version did not know, and is no larger than what is read.
namespace spindle_twin::rom::tests {
namespace file_versions_test {

using spindle_twin::tests::Bytes;
using spindle_twin::tests::refusal_of;
using spindle_twin::tests::WireField;

constexpr std::uint64_t version_field = 1, certificate_field = 17;

/// The file of that version with this certificate, or with none where it is empty.
Bytes file_of(const Network& network, std::uint64_t version, const std::vector<WireField>& certificate) {
  const Bytes good = encode_network(network);
  std::vector<WireField> fields = spindle_twin::tests::take_message(std::span(good).subspan(header::size)).value();
  fields.front().value = version;
  EXPECT_EQ(fields.front().number, version_field);
  std::erase_if(fields, [](const WireField& field) { return field.number == certificate_field; });
  if (!certificate.empty()) {
    fields.push_back({certificate_field, 2, WireField::Kind::message, 0, {}, certificate});
  }
  const Bytes payload = spindle_twin::tests::written(fields);
  Bytes bytes(good.begin(), good.begin() + header::size);
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  header::put_little_endian(std::uint64_t{payload.size()}, bytes.data() + header::length_at);
  const Sha256 hash = sha256(payload);
  std::copy(hash.begin(), hash.end(), bytes.begin() + header::hash_at);
  return bytes;
}

/// What is refused before `first`, and from then on taken as far as its version goes.
void expect_from_version(std::uint64_t first, const Network& network, const std::vector<WireField>& certificate,
                         const std::string& what) {
  for (std::uint64_t version = 0; version <= 7; ++version) {
    const Bytes bytes = file_of(network, version, certificate);
    const std::string said = refusal_of([&] { decode_rom_file(bytes, "x.rom"); });
    const bool unknown = version < 1 || version > 6;
    EXPECT_EQ(said.find("is unknown; this program reads 1 to 6") != std::string::npos, unknown) << version << said;
    if (unknown) continue;
    const std::string begin = "x.rom: schema_version: " + std::to_string(version) + " with ";
    const bool older = said.starts_with(begin) && said.ends_with(" " + std::to_string(first));
    EXPECT_EQ(older, version < first) << what << " in version " << version << ": " << said;
    EXPECT_EQ(said.find("schema_version") != std::string::npos, version < first) << what << " " << version << said;
  }
}

TEST(FileVersions, each_thing_is_refused_in_files_that_are_older_than_it_and_taken_from_then_on) {
  expect_from_version(1, make_single_node(), {}, "nothing new");
  expect_from_version(2, make_network_with_circuit({2, 2, 2, true}, 3), {}, "a circuit");
  Network by_hand = make_single_node();
  by_hand.hand_written = true;
  expect_from_version(3, by_hand, {}, "a hand-written network");
  Network heat = make_copper_node();
  expect_from_version(4, heat, {}, "the law of a heat alone");
  Network conductances = make_network_with_laws();
  for (HeatSource& source : conductances.boundaries.sources) source.physics.reset();
  for (Conductance& conductance : conductances.boundaries.conductances) {
    if (conductance.physics && conductance.physics->circuit >= 0) conductance.physics.reset();
  }
  conductances.boundaries.circuits.clear();
  conductances.boundaries.operating.flow_kg_per_s.resize(0);
  expect_from_version(4, conductances, {}, "laws of conductances alone");
  Network measured = make_single_node();
  measured.boundaries.sources.back().measured = true;
  expect_from_version(5, measured, {}, "a measured heat");
}

TEST(FileVersions, errors_of_each_kind_of_output_come_with_version_3) {
  const Network network = make_single_node();
  for (std::uint64_t kind = 8; kind <= 12; ++kind) {
    // Three numbers each, or four: of as many outputs as no network here has.
    const Bytes zeros(12 * sizeof(double), 0);
    expect_from_version(3, network, {{kind, 2, WireField::Kind::numbers, 0, zeros, {}}}, "errors of an output");
  }
}

TEST(FileVersions, a_limit_and_the_share_that_keeps_it_each_come_with_version_6) {
  const Network network = make_single_node();
  const WireField number{1, 1, WireField::Kind::fixed, 0, spindle_twin::tests::bytes_of(0.5), {}};
  const WireField limit{13, 2, WireField::Kind::message, 0, {}, {number}};
  const WireField content{14, 1, WireField::Kind::fixed, 0, spindle_twin::tests::bytes_of(0.95), {}};
  expect_from_version(6, network, {limit}, "a limit");
  expect_from_version(6, network, {content}, "a share of the cases");
  expect_from_version(6, network, {limit, content}, "both");
}

TEST(FileVersions, a_file_without_nodes_is_refused_by_name) {
  Network network = make_single_node();
  network.nodes.clear();
  const Bytes bytes = encode_network(network);
  EXPECT_EQ(refusal_of([&] { decode_rom_file(bytes, "x.rom"); }), "x.rom: nodes: none; at least one is needed");
}

/// With room for a signature, which is added later. The name of the spindle makes it as long as is wanted.
TEST(FileVersions, of_a_network_is_written_up_to_the_largest_size_that_is_read) {
  Network network = make_single_node();
  network.spindle = "n";
  const std::size_t without_name = encode_network(network).size() - 1, longer_length = 3;  // of the name: four bytes
  network.spindle.assign(rom_largest_file_bytes - signature_block_size - without_name - longer_length, 'n');
  const std::string nowhere = "/nowhere/x.rom";
  EXPECT_EQ(refusal_of([&] { write_network(network, nowhere); }),
            nowhere + ": cannot be written: No such file or directory");
}

}  // namespace file_versions_test
}  // namespace spindle_twin::rom::tests

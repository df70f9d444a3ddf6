#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "rom/file/payload.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/signature.hpp"
#include "tests/rom/synthetic_network.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

/// What a network file may hold at most, and how it is told from another.
namespace spindle_twin::rom::tests {
namespace long_lists_test {

using spindle_twin::tests::refusal_of;

std::string said_of(const Network& network) {
  return refusal_of([&] { decode_network(encode_network(network), "x.rom"); });
}

TEST(RomFile, a_list_has_ten_thousand_items_at_most) {
  Network network = make_single_node();
  for (std::size_t i = 0; i < most_items; ++i) network.boundaries.plausible.push_back({"x", between(0.0, 1.0)});
  EXPECT_EQ(said_of(network), "accepted");
  network.boundaries.plausible.push_back({"x", between(0.0, 1.0)});
  EXPECT_NE(said_of(network).find("a list is too long"), std::string::npos) << said_of(network);
}

TEST(RomFile, a_circuit_has_ten_thousand_segments_at_most) {
  Network network = make_single_node();
  network.boundaries.circuits = {{"water", 0, 4180.0, std::vector<int>(most_items, 0)}};
  network.boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, 0.1);
  EXPECT_NE(said_of(network).find("is in a circuit twice"), std::string::npos) << said_of(network);
  network.boundaries.circuits[0].segments.push_back(0);
  EXPECT_NE(said_of(network).find("payload: malformed"), std::string::npos) << said_of(network);
}

TEST(RomFile, a_network_has_two_thousand_nodes_at_most) {
  Network network = make_single_node();
  network.nodes.resize(most_nodes, network.nodes[0]);
  EXPECT_EQ(said_of(network), "x.rom: capacity_J_per_K: 1 numbers where 2000 x 2000 are needed");
  network.nodes.push_back(network.nodes[0]);
  EXPECT_NE(said_of(network).find("a list is too long"), std::string::npos) << said_of(network);
  EXPECT_EQ(refusal_of([&] { check_network(network, "x.rom"); }), "x.rom: nodes: 2001; at most 2000 are allowed");
}

TEST(RomFile, lists_that_belong_together_are_not_written_apart) {
  const Network good = make_network_with_circuit({2, 2, 2, true}, 3);
  EXPECT_NO_THROW(encode_payload(good));
  const auto with = [&](const auto& change) {
    Network network = good;
    change(network);
    return network;
  };
  EXPECT_THROW(encode_payload(with([](Network& n) { n.factors_m.pop_back(); })), std::invalid_argument);
  EXPECT_THROW(encode_payload(with([](Network& n) { n.boundaries.sources.pop_back(); })), std::invalid_argument);
  EXPECT_THROW(encode_payload(with([](Network& n) { n.boundaries.environments.pop_back(); })), std::invalid_argument);
  EXPECT_THROW(encode_payload(with([](Network& n) { n.boundaries.circuits.clear(); })), std::invalid_argument);
}

TEST(RomFile, is_told_by_its_first_eight_bytes) {
  const spindle_twin::tests::TemporaryFolder folder;
  const std::string magic = "SPINROM\n";
  EXPECT_TRUE(is_rom_file(folder.write("magic", magic)));
  EXPECT_TRUE(is_rom_file(folder.write("more", magic + "anything")));
  EXPECT_FALSE(is_rom_file(folder.write("cut", magic.substr(0, 7))));
  EXPECT_FALSE(is_rom_file(folder.write("empty", "")));
  EXPECT_FALSE(is_rom_file(folder.write("other", "SPINROM\r")));
  EXPECT_FALSE(is_rom_file(folder.write("first", "XPINROM\n")));
  EXPECT_FALSE(is_rom_file(folder.file("nothing")));
  EXPECT_FALSE(is_rom_file(folder.path().string()));
}

TEST(RomFile, a_signed_one_that_is_cut_or_too_long_says_so_and_that_a_signature_belongs_to_it) {
  const std::vector<std::uint8_t> whole = sign_bytes(encode_network(make_single_node()), make_private_key());
  const std::size_t payload = whole.size() - 52 - signature_block_size;
  for (const std::size_t length :
       {std::size_t{52}, std::size_t{100}, 52 + payload, whole.size() - 1, whole.size() + 1, whole.size() + 300}) {
    std::vector<std::uint8_t> bytes = whole;
    bytes.resize(length);
    const std::string said = refusal_of([&] { decode_rom_file(bytes, "x.rom"); });
    EXPECT_EQ(said, std::string("x.rom: payload: ") + (length < whole.size() ? "truncated: " : "too long: ") +
                        std::to_string(length - 52) + " bytes, the header says " + std::to_string(payload) +
                        " and a signature of 104");
  }
}

TEST(RomFile, a_cut_header_says_how_much_of_it_is_there) {
  const std::vector<std::uint8_t> whole = encode_network(make_single_node());
  const auto cut_to = [&](std::ptrdiff_t length) {
    return refusal_of([&] { decode_rom_file({whole.begin(), whole.begin() + length}, "x.rom"); });
  };
  EXPECT_EQ(cut_to(51), "x.rom: header: truncated: 51 of 52 bytes");
  const auto payload = static_cast<std::ptrdiff_t>(whole.size()) - 52;
  EXPECT_EQ(cut_to(52), "x.rom: payload: truncated: 0 bytes, the header says " + std::to_string(payload));
  EXPECT_EQ(cut_to(3), "x.rom: header: truncated: 3 of 52 bytes");
  EXPECT_EQ(cut_to(0), "x.rom: not a .rom file");
  EXPECT_EQ(refusal_of([&] { decode_rom_file({'S', 'P', 'A'}, "x.rom"); }), "x.rom: not a .rom file");
  EXPECT_EQ(
      refusal_of([&] {
        decode_rom_file({'[', 's', 'p'}, "x.toml");
      }),
      "x.toml: not a .rom file; `spindle-twin build` makes one of a spindle's description, `spindle-twin assemble` "
      "of a network written by hand");
}

}  // namespace long_lists_test
}  // namespace spindle_twin::rom::tests

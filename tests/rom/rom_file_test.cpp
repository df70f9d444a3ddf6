#include <gtest/gtest.h>
#include <sodium.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/rom/synthetic_network.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::rom::tests {
namespace rom_file_test {

using spindle_twin::tests::refusal_of;

namespace fs = std::filesystem;

constexpr std::size_t header_size = 52;
constexpr std::size_t hash_at = 20;

Network small_network() { return make_synthetic_network({2, 2, 2, true}, 7); }

std::string decode_refusal(const std::vector<std::uint8_t>& bytes) {
  return refusal_of([&] { decode_network(bytes, "x.rom"); });
}

void expect_refused(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << "message: '" << message << "', expected in it: '" << part << "'";
  EXPECT_NE(message.find("x.rom"), std::string::npos) << message;
}

/// Makes header and payload agree again, so that what lies behind the hash is reached.
void renew_hash(std::vector<std::uint8_t>& bytes) {
  crypto_hash_sha256(bytes.data() + hash_at, bytes.data() + header_size, bytes.size() - header_size);
}

TEST(RomFile, round_trip_is_bit_exact) {
  const spindle_twin::tests::TemporaryFolder folder;
  Network network = make_synthetic_network({}, 5);
  network.boundaries.operating.load = -0.0;
  network.certificate.seed = 0xfedcba9876543210u;
  const Eigen::Index n = network.capacity_J_per_K.rows();
  network.outlines = {{"shaft", (Eigen::MatrixXd(2, 3) << 0.0, 0.02, 0.02, 0.0, 0.0, 0.1).finished()}};
  network.contact_pressures = {{"a/b", 1.5e6, Eigen::VectorXd::LinSpaced(n, -3e5, 2e5)},
                               {"plain", 0.0, Eigen::VectorXd::Zero(n)}};
  write_network(network, folder.file("x.rom"));
  EXPECT_EQ(folder.files(), 1) << "a temporary file is left";
  const Network back = read_network(folder.file("x.rom"));

  // The encoding is a function of every field, so equal bytes mean equal fields; the samples prove that it is.
  EXPECT_EQ(encode_network(back), encode_network(network));
  EXPECT_EQ(back.spindle, network.spindle);
  EXPECT_EQ(back.description_hash, network.description_hash);
  EXPECT_EQ(back.nodes.back().name, "air");
  EXPECT_EQ(back.nodes[3].part, network.nodes[3].part);
  EXPECT_EQ(back.nodes[3].z_m, network.nodes[3].z_m);
  EXPECT_EQ(back.capacity_J_per_K, network.capacity_J_per_K);
  EXPECT_EQ(back.conduction_W_per_K, network.conduction_W_per_K);
  EXPECT_EQ(back.source_distribution, network.source_distribution);
  ASSERT_EQ(back.factors_m.size(), network.factors_m.size());
  for (std::size_t j = 0; j < back.factors_m.size(); ++j) {
    const Conductance& a = back.boundaries.conductances[j];
    const Conductance& b = network.boundaries.conductances[j];
    EXPECT_EQ(back.factors_m[j], network.factors_m[j]);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.nominal_W_per_m2K, b.nominal_W_per_m2K);
    EXPECT_EQ(a.area_m2, b.area_m2);
    EXPECT_EQ(a.environment, b.environment);
    EXPECT_EQ(a.part_a, b.part_a);
    EXPECT_EQ(a.part_b, b.part_b);
    EXPECT_EQ(a.law.constant, b.law.constant);
    ASSERT_EQ(a.law.speed_terms.size(), b.law.speed_terms.size());
    ASSERT_EQ(a.fit.has_value(), b.fit.has_value());
    if (a.fit) {
      EXPECT_EQ(a.fit->pressure_per_outer_rise_Pa_per_K, b.fit->pressure_per_outer_rise_Pa_per_K);
    }
  }
  EXPECT_EQ(back.boundaries.sources[1].law.speed_terms[1].exponent, 1.5);
  EXPECT_TRUE(back.boundaries.sources[1].law.zero_at_standstill);
  EXPECT_EQ(back.boundaries.environments[0].kind, EnvironmentKind::coolant);
  EXPECT_EQ(back.boundaries.operating.environment_K, network.boundaries.operating.environment_K);
  EXPECT_TRUE(std::signbit(back.boundaries.operating.load));
  EXPECT_EQ(back.boundaries.reference_temperature_K, 300.15);
  EXPECT_EQ(back.key_points[1].row, network.key_points[1].row);
  EXPECT_EQ(back.parts[1].candidate_rows, network.parts[1].candidate_rows);
  EXPECT_EQ(back.deformations[0].row_m_per_K, network.deformations[0].row_m_per_K);
  ASSERT_EQ(back.outlines.size(), 1u);
  EXPECT_EQ(back.outlines[0].part, "shaft");
  EXPECT_EQ(back.outlines[0].points_m, network.outlines[0].points_m);
  ASSERT_EQ(back.contact_pressures.size(), 2u);
  EXPECT_EQ(back.contact_pressures[0].name, "a/b");
  EXPECT_EQ(back.contact_pressures[0].assembly_pressure_Pa, 1.5e6);
  EXPECT_EQ(back.contact_pressures[0].row_Pa_per_K, network.contact_pressures[0].row_Pa_per_K);
  EXPECT_EQ(back.contact_pressures[1].row_Pa_per_K, network.contact_pressures[1].row_Pa_per_K);
  EXPECT_EQ(back.certificate.seed, network.certificate.seed);
  EXPECT_EQ(back.certificate.worst.nose_um, 0.06);
  EXPECT_EQ(back.certificate.median.part_max_K, 0.2);
}

TEST(RomFile, every_truncation_is_refused) {
  const std::vector<std::uint8_t> bytes = encode_network(small_network());
  ASSERT_EQ(decode_refusal(bytes), "accepted");
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    expect_refused(decode_refusal(cut), length == 0 ? "not a .rom file" : "truncated");
  }
  std::vector<std::uint8_t> longer = bytes;
  longer.push_back(0);
  expect_refused(decode_refusal(longer), "too long");
}

TEST(RomFile, every_flipped_bit_is_refused) {
  std::vector<std::uint8_t> bytes = encode_network(small_network());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      bytes[at] ^= static_cast<std::uint8_t>(1u << bit);
      ASSERT_NE(decode_refusal(bytes), "accepted") << "byte " << at << " bit " << bit;
      bytes[at] ^= static_cast<std::uint8_t>(1u << bit);
    }
  }
}

TEST(RomFile, header_errors_say_what_is_wrong) {
  const std::vector<std::uint8_t> good = encode_network(small_network());
  std::vector<std::uint8_t> bytes = good;
  bytes[8] = 3;
  expect_refused(decode_refusal(bytes), "format version: 3 is unknown; this program reads 1 and 2");
  bytes = good;
  bytes[19] = 0x7f;  // a payload of 9e18 bytes
  expect_refused(decode_refusal(bytes), "truncated");
  bytes = good;
  bytes[header_size + 30] ^= 1;
  expect_refused(decode_refusal(bytes), "damaged: its SHA-256 is not the header's");
  const std::string text = "[spindle]\nname = \"not a network\"\n";
  expect_refused(decode_refusal({text.begin(), text.end()}), "not a .rom file");
}

TEST(RomFile, unknown_schema_version_is_refused) {
  std::vector<std::uint8_t> bytes = encode_network(small_network());
  ASSERT_EQ(bytes[header_size], 0x08) << "schema_version is the first field";
  bytes[header_size + 1] = 9;
  renew_hash(bytes);
  expect_refused(decode_refusal(bytes), "schema_version: 9 is unknown; this program reads 1 to 6");
}

TEST(RomFile, a_number_of_a_law_that_cannot_be_read_is_refused) {
  std::vector<std::uint8_t> bytes = encode_network(make_copper_node());
  const std::string number = "rated_current_A";
  const auto name = std::search(bytes.begin(), bytes.end(), number.begin(), number.end());
  ASSERT_NE(name, bytes.end());
  const auto tag = name + static_cast<std::ptrdiff_t>(number.size());
  ASSERT_EQ(*tag, 2U << 3U | 1U) << "field 2, eight bytes";
  *tag = 3U << 3U;  // a field that this program does not know, of a number that does not end
  std::fill_n(tag + 1, sizeof(double), std::uint8_t{0x80});
  renew_hash(bytes);
  expect_refused(decode_refusal(bytes), "x.rom");
}

TEST(RomFile, a_payload_behind_a_valid_hash_cannot_crash_the_reader) {
  const std::uint64_t seed = 20240611;
  std::cout << "seed " << seed << "\n";
  std::mt19937_64 random(seed);
  const std::vector<std::uint8_t> good = encode_network(small_network());
  int refused = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::uint8_t> bytes = good;
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int c = 0; c < changes; ++c) {
      bytes[header_size + random() % (bytes.size() - header_size)] = static_cast<std::uint8_t>(random());
    }
    renew_hash(bytes);
    if (!decode_refusal(bytes).empty()) ++refused;
  }
  EXPECT_GT(refused, 1000);
}

using Bytes = std::vector<std::uint8_t>;

std::uint64_t read_varint(const Bytes& bytes, std::size_t& at) {
  std::uint64_t value = 0;
  for (int shift = 0; at < bytes.size() && shift < 64; shift += 7) {
    value |= static_cast<std::uint64_t>(bytes[at] & 0x7fU) << shift;
    if ((bytes[at++] & 0x80U) == 0) break;
  }
  return value;
}

void append_varint(std::uint64_t value, Bytes& bytes) {
  for (; value > 0x7f; value >>= 7) bytes.push_back(static_cast<std::uint8_t>(value | 0x80U));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

/// A field of a message that has a length, as protobuf writes it: key, length, content.
struct Field {
  std::size_t length_at = 0, begin = 0, end = 0;
};

/// The last of each number, of those that have a length; none where the bytes are no message.
std::map<std::uint64_t, Field> fields_of(const Bytes& bytes) {
  std::map<std::uint64_t, Field> found;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::uint64_t key = read_varint(bytes, at);
    const std::size_t length_at = at;
    switch (key & 7U) {
      case 0:
        read_varint(bytes, at);
        break;
      case 1:
        at += 8;
        break;
      case 2: {
        const auto length = static_cast<std::size_t>(read_varint(bytes, at));
        if (length > bytes.size() - at) return {};
        found[key >> 3] = {length_at, at, at + length};
        at += length;
        break;
      }
      default:
        return {};
    }
    if (at > bytes.size()) return {};
  }
  return found;
}

/// Visits the bytes of a message with one of its fields, or of a field's fields, broken: at its end stands a byte that
/// begins no field and is no number. Lengths agree with it. Names are left alone.
void break_each_field(const Bytes& message, const std::string& name,
                      const std::function<void(const Bytes&, const std::string&)>& visit) {
  for (const auto& [number, field] : fields_of(message)) {
    const auto at = [&](std::size_t place) { return message.begin() + static_cast<std::ptrdiff_t>(place); };
    const Bytes content(at(field.begin), at(field.end));
    if (std::all_of(content.begin(), content.end(), [](std::uint8_t byte) { return byte >= ' '; })) continue;
    const auto with = [&](const Bytes& changed, const std::string& where) {
      Bytes whole(message.begin(), at(field.length_at));
      append_varint(changed.size(), whole);
      whole.insert(whole.end(), changed.begin(), changed.end());
      whole.insert(whole.end(), at(field.end), message.end());
      visit(whole, where);
    };
    const std::string field_name = name + "." + std::to_string(number);
    Bytes broken = content;
    broken.push_back(0x07);
    with(broken, field_name);
    break_each_field(content, field_name, with);
  }
}

TEST(RomFile, a_broken_message_of_every_kind_behind_a_valid_hash_is_refused) {
  Network network = make_network_with_laws();
  network.contact_pressures = {{"a/b", 1.5e6, Eigen::VectorXd::Zero(network.capacity_J_per_K.rows())}};
  network.outlines = {{"shaft", (Eigen::MatrixXd(2, 3) << 0.0, 0.02, 0.02, 0.0, 0.0, 0.1).finished()}};
  network.boundaries.plausible = {{"speed_rpm", between(0.0, 20000.0)}};
  const Bytes good = encode_network(network);
  ASSERT_EQ(decode_refusal(good), "accepted");
  std::set<std::string> broken;
  break_each_field(Bytes(good.begin() + header_size, good.end()), "network",
                   [&](const Bytes& payload, const std::string& name) {
                     Bytes bytes(good.begin(), good.begin() + header_size);
                     for (std::size_t i = 0; i < 8; ++i) {
                       bytes[12 + i] = static_cast<std::uint8_t>(std::uint64_t{payload.size()} >> (8 * i));
                     }
                     bytes.insert(bytes.end(), payload.begin(), payload.end());
                     renew_hash(bytes);
                     EXPECT_NE(decode_refusal(bytes), "accepted") << name;
                     broken.insert(name);
                   });
  EXPECT_GT(broken.size(), 30U);
  EXPECT_TRUE(broken.contains("network.9.5.3")) << "a number of the law of a heat source";
}

TEST(RomFile, physics_that_does_not_hold_is_refused) {
  using Change = std::function<void(Network&)>;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, Change>> cases = {
      {"capacity_J_per_K: has a value that is not finite", [&](Network& n) { n.capacity_J_per_K(1, 1) = nan; }},
      {"capacity_J_per_K: is not symmetric", [](Network& n) { n.capacity_J_per_K(0, 1) += 1.0; }},
      {"capacity_J_per_K: is not positive definite", [](Network& n) { n.capacity_J_per_K(2, 2) = -1.0; }},
      {"conduction_W_per_K: is not symmetric",
       [](Network& n) {
         n.conduction_W_per_K(0, 1) += 1.0;
         n.conduction_W_per_K(0, 0) -= 1.0;
       }},
      {"conduction_W_per_K: rows do not sum to zero", [](Network& n) { n.conduction_W_per_K(0, 0) += 1.0; }},
      {"conduction_W_per_K: is not positive semidefinite", [](Network& n) { n.conduction_W_per_K *= -1.0; }},
      {"conduction_W_per_K: 3 numbers where 9 x 9 are needed", [](Network& n) { n.conduction_W_per_K.resize(3, 1); }},
      {"nodes: none", [](Network& n) { n.nodes.clear(); }},
      {"conductance contact 0 factor: columns do not sum to zero", [](Network& n) { n.factors_m[0](0, 0) += 1.0; }},
      {"conductance contact 0 factor: must have one row per node and at least one column",
       [](Network& n) { n.factors_m[0].resize(9, 0); }},
      {"conductance contact 0 factor: 5 numbers", [](Network& n) { n.factors_m[0].resize(5, 1); }},
      {"conductance contact 0 nominal_W_per_m2K: must be finite and not negative",
       [](Network& n) { n.boundaries.conductances[0].nominal_W_per_m2K = -1.0; }},
      {"conductance contact 0 environment: names one that does not exist",
       [](Network& n) { n.boundaries.conductances[0].environment = 2; }},
      {"conductance contact 0 part: names one that does not exist",
       [](Network& n) { n.boundaries.conductances[0].part_a = 99; }},
      {"conductance cavity law exponent: must be finite and not negative",
       [](Network& n) { n.boundaries.conductances[1].law.speed_terms[0].exponent = -0.5; }},
      {"conductance contact 0: name is used twice",
       [](Network& n) { n.boundaries.conductances[1].name = "contact 0"; }},
      {"reference_speed_rpm: must be positive", [](Network& n) { n.boundaries.reference_speed_rpm = 0.0; }},
      {"reference_temperature_K: must be finite and above 0 K",
       [](Network& n) { n.boundaries.reference_temperature_K = -3.0; }},
      {"environment coolant operating_K: must be finite and above 0 K",
       [&](Network& n) { n.boundaries.operating.environment_K[0] = nan; }},
      {"source motor distribution: weights sum to 1.5", [](Network& n) { n.source_distribution(0, 1) += 0.5; }},
      {"key point point 0 row: weights sum to", [](Network& n) { n.key_points[0].row *= 0.5; }},
      {"key point point 0 row: 2 numbers where one per node, 9, is needed",
       [](Network& n) { n.key_points[0].row = Eigen::VectorXd::Ones(2); }},
      {"part plate 1 candidate 0: weights sum to", [](Network& n) { n.parts[1].candidate_rows(0, 0) = 3.0; }},
      {"part plate 1 candidates: must have at least one row",
       [](Network& n) { n.parts[1].candidate_rows.resize(0, 9); }},
      {"deformation nose row: has a value that is not finite",
       [&](Network& n) { n.deformations[0].row_m_per_K[3] = nan; }},
      {"deformations: none; the first is the nose", [](Network& n) { n.deformations.clear(); }},
      {"contact pressure fit row: has a value that is not finite",
       [&](Network& n) {
         n.contact_pressures = {{"fit", 1.0, Eigen::VectorXd::Constant(n.capacity_J_per_K.rows(), nan)}};
       }},
      {"contact pressure fit row: 2 numbers where one per node",
       [](Network& n) {
         n.contact_pressures = {{"fit", 1.0, Eigen::VectorXd::Ones(2)}};
       }},
      {"certificate nose_um: must be finite and not negative", [&](Network& n) { n.certificate.worst.nose_um = nan; }},
  };
  const spindle_twin::tests::TemporaryFolder folder;
  for (const auto& [message, change] : cases) {
    Network network = small_network();
    change(network);
    expect_refused(decode_refusal(encode_network(network)), message);
    EXPECT_NE(refusal_of([&] { write_network(network, folder.file("bad.rom")); }), "accepted") << message;
  }
  EXPECT_EQ(folder.files(), 0) << "a refused network left a file";
}

TEST(RomFile, a_file_above_64_MiB_is_not_read_at_all) {
  const spindle_twin::tests::TemporaryFolder folder;
  const std::string path = folder.file("x.rom");
  write_network(small_network(), path);
  fs::resize_file(path, (64U << 20U) + 1U);  // no more on the disk: what is behind the network is a hole
  expect_refused(refusal_of([&] { read_network(path); }), "67108865 bytes; at most 67108864 are allowed");
}

TEST(RomFile, a_missing_file_or_folder_is_one_clear_error) {
  const spindle_twin::tests::TemporaryFolder folder;
  const std::string missing = folder.file("x.rom");
  EXPECT_EQ(refusal_of([&] { read_network(missing); }),
            missing + ": cannot be opened for reading: No such file or directory");
  const std::string nowhere = folder.file("no/x.rom");
  EXPECT_EQ(refusal_of([&] { write_network(small_network(), nowhere); }),
            nowhere + ": cannot be written: No such file or directory");
  expect_refused(refusal_of([&] { read_network(fs::path(missing).parent_path().string() + "/../x.rom/"); }), "cannot");
}

}  // namespace rom_file_test
}  // namespace spindle_twin::rom::tests

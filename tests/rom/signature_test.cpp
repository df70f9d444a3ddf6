#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "rom/file/rom_file.hpp"
#include "rom/file/signature.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/synthetic_network.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::rom::tests {
namespace signature_test {

using spindle_twin::tests::refusal_of;

namespace fs = std::filesystem;

class Signature : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return folder.file(name); }

  static std::string decode_refusal(const std::vector<std::uint8_t>& bytes) {
    return refusal_of([&] { decode_rom_file(bytes, "x.rom"); });
  }

  spindle_twin::tests::TemporaryFolder folder;
  PrivateKey key = make_private_key();
  std::vector<std::uint8_t> plain = encode_network(make_single_node());
  std::vector<std::uint8_t> with_signature = sign_bytes(plain, key);
};

TEST_F(Signature, names_its_key_and_leaves_the_network_as_it_is) {
  const RomFile read = decode_rom_file(with_signature, "x.rom");
  ASSERT_TRUE(read.signed_by);
  EXPECT_EQ(*read.signed_by, public_key(key));
  EXPECT_EQ(encode_network(read.network), plain);
  EXPECT_EQ(read.sha256, decode_rom_file(plain, "x.rom").sha256);
  EXPECT_FALSE(decode_rom_file(plain, "x.rom").signed_by);
}

TEST_F(Signature, signing_again_replaces_it) {
  const PrivateKey other = make_private_key();
  const std::vector<std::uint8_t> twice = sign_bytes(with_signature, other);
  EXPECT_EQ(twice.size(), with_signature.size());
  EXPECT_EQ(*decode_rom_file(twice, "x.rom").signed_by, public_key(other));
}

/// Also cut off exactly behind the payload, where an unsigned file would end.
TEST_F(Signature, every_truncation_is_refused) {
  for (std::size_t length = 0; length < with_signature.size(); ++length) {
    const std::vector<std::uint8_t> cut(with_signature.begin(),
                                        with_signature.begin() + static_cast<std::ptrdiff_t>(length));
    ASSERT_NE(decode_refusal(cut), "accepted") << length;
  }
  std::vector<std::uint8_t> longer = with_signature;
  longer.push_back(0);
  EXPECT_NE(decode_refusal(longer).find("too long"), std::string::npos);
  longer = plain;
  longer.insert(longer.end(), with_signature.end() - static_cast<std::ptrdiff_t>(signature_block_size),
                with_signature.end());
  EXPECT_NE(decode_refusal(longer).find("too long"), std::string::npos) << "a block without its format version";
}

TEST_F(Signature, every_flipped_bit_is_refused) {
  for (std::size_t at = 0; at < with_signature.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      with_signature[at] ^= static_cast<std::uint8_t>(1u << bit);
      ASSERT_NE(decode_refusal(with_signature), "accepted") << "byte " << at << " bit " << bit;
      with_signature[at] ^= static_cast<std::uint8_t>(1u << bit);
    }
  }
}

TEST_F(Signature, of_another_file_does_not_fit) {
  Network other = make_single_node();
  other.boundaries.sources[0].nominal_W = 200.0;
  std::vector<std::uint8_t> forged = sign_bytes(encode_network(other), make_private_key());
  std::copy(with_signature.end() - static_cast<std::ptrdiff_t>(signature_block_size), with_signature.end(),
            forged.end() - static_cast<std::ptrdiff_t>(signature_block_size));
  EXPECT_EQ(decode_refusal(forged), "x.rom: signature: does not fit the file, or is damaged");
}

TEST_F(Signature, keys_survive_their_files) {
  write_private_key(key, file("my.key"));
  write_public_key(public_key(key), file("my.pub"));
  struct stat status {};
  ASSERT_EQ(::stat(file("my.key").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0600u);
  EXPECT_EQ(read_public_key(file("my.pub")), public_key(key));
  EXPECT_EQ(read_private_key(file("my.key")).secret, key.secret);
  PublicKey parsed{};
  EXPECT_TRUE(parse_public_key(to_hex(public_key(key)), parsed));
  EXPECT_EQ(parsed, public_key(key));
  EXPECT_FALSE(parse_public_key("abc", parsed));
  EXPECT_FALSE(parse_public_key(std::string(64, 'g'), parsed));
}

TEST_F(Signature, a_private_key_is_never_overwritten_and_never_shared) {
  write_private_key(key, file("my.key"));
  EXPECT_EQ(refusal_of([&] { write_private_key(make_private_key(), file("my.key")); }),
            file("my.key") + ": cannot be written: File exists");
  EXPECT_EQ(read_private_key(file("my.key")).secret, key.secret);
  EXPECT_EQ(folder.files(), 1) << "a temporary file is left";
  ASSERT_EQ(::chmod(file("my.key").c_str(), 0640), 0);
  EXPECT_EQ(refusal_of([&] { read_private_key(file("my.key")); }),
            file("my.key") + ": permissions: a private key must be its owner's alone: chmod 600, it has 0640");
}

TEST_F(Signature, a_key_file_that_is_none_is_one_clear_error) {
  write_public_key(public_key(key), file("my.pub"));
  EXPECT_EQ(refusal_of([&] { read_public_key(file("none.pub")); }), file("none.pub") + ": cannot be read as a file");
  ASSERT_EQ(::chmod(file("my.pub").c_str(), 0600), 0);
  EXPECT_NE(refusal_of([&] { read_private_key(file("my.pub")); }).find("ed25519_private_seed"), std::string::npos);
  write_whole_file(file("short.pub"), std::string("ed25519_public_key = \"00ff\"\n"));
  EXPECT_EQ(refusal_of([&] { read_public_key(file("short.pub")); }),
            file("short.pub") + ":1: ed25519_public_key: must be 64 hex digits");
}

TEST_F(Signature, a_file_is_signed_in_place_or_left_alone) {
  write_whole_file(file("x.rom"), plain);
  sign_file(file("x.rom"), key);
  EXPECT_EQ(read_whole_file(file("x.rom"), 1u << 20), with_signature);
  write_whole_file(file("text.rom"), std::string("no network"));
  EXPECT_NE(refusal_of([&] { sign_file(file("text.rom"), key); }).find("not a .rom file"), std::string::npos);
  EXPECT_EQ(read_whole_file(file("text.rom"), 100).size(), 10u);
}

}  // namespace signature_test
}  // namespace spindle_twin::rom::tests

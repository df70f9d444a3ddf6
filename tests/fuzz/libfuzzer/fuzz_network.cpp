#include <sodium.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "rom/file/file_header.hpp"
#include "rom/file/signature.hpp"
#include "tests/fuzz/check_network_file.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spindle_twin::rom::checked_network_file({data, data + size});
  return 0;
}

namespace {

namespace header = spindle_twin::rom::header;

void change_a_number(std::vector<std::uint8_t>& payload, std::mt19937& random) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  static const std::vector<double> odd = {0.0,    -0.0,  1.0,      -1.0,
                                          1e-300, 1e300, 1e16,     1.5e-9,
                                          273.0,  -1e9,  infinity, std::numeric_limits<double>::quiet_NaN()};
  if (payload.size() < sizeof(double)) return;
  const double number = odd[random() % odd.size()];
  std::memcpy(payload.data() + random() % (payload.size() - sizeof(double) + 1), &number, sizeof number);
}

}  // namespace

/// Almost every change is stopped by the hash, so most changes are made behind it: to the payload, after which length,
/// hash and signature are made to fit again.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  using spindle_twin::rom::signature_block_size;
  std::mt19937 random(seed);
  const bool is_signed = size > header::version_at && data[header::version_at] == 2;
  const std::size_t around = header::size + (is_signed ? signature_block_size : 0);
  if (size <= around || max_size <= around || random() % 16 == 0) return LLVMFuzzerMutate(data, size, max_size);

  std::vector<std::uint8_t> payload(data + header::size, data + size - (around - header::size));
  if (random() % 3 == 0) {
    change_a_number(payload, random);
  } else {
    const std::size_t room = max_size - around;
    const std::size_t old_size = std::min(payload.size(), room);
    payload.resize(room);
    payload.resize(LLVMFuzzerMutate(payload.data(), old_size, room));
  }
  std::vector<std::uint8_t> bytes(data, data + header::size);
  header::put_little_endian(static_cast<std::uint64_t>(payload.size()), bytes.data() + header::length_at);
  crypto_hash_sha256(bytes.data() + header::hash_at, payload.data(), payload.size());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  if (is_signed) {
    const spindle_twin::rom::PublicKey any_seed{};
    spindle_twin::rom::PrivateKey key;
    spindle_twin::rom::PublicKey unused;
    crypto_sign_seed_keypair(unused.data(), key.secret.data(), any_seed.data());
    bytes = spindle_twin::rom::sign_bytes(std::move(bytes), key);
  }
  std::copy(bytes.begin(), bytes.end(), data);
  return bytes.size();
}

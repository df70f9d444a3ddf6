#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "firmware/acquire/stream_decoder.hpp"
#include "tests/fuzz/check_stream.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spindle_twin::firmware::checked_stream({data, size});
  return 0;
}

/// Almost every change is stopped by the checksum, so most changes are made behind it: to the payload of the first
/// frame, after which its length and checksum are made to fit again. What follows the frame stays.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  using Decoder = spindle_twin::firmware::StreamDecoder;
  constexpr std::size_t header = Decoder::header_bytes;
  std::mt19937 random(seed);
  const std::size_t payload = size > header ? (std::size_t{data[4]} << 8U) + data[5] : 0;
  const std::size_t frame_bytes = header + payload + Decoder::crc_bytes;
  if (random() % 4 == 0 || payload == 0 || frame_bytes > size) return LLVMFuzzerMutate(data, size, max_size);

  std::vector<std::uint8_t> bytes(data, data + header + payload);
  const std::vector<std::uint8_t> behind(data + frame_bytes, data + size);
  const std::size_t room = std::min(Decoder::longest_payload, max_size - header - Decoder::crc_bytes);
  bytes.resize(header + std::max(payload, room));
  const std::size_t changed = LLVMFuzzerMutate(bytes.data() + header, std::min(payload, room), room);
  bytes.resize(header + changed);
  bytes[4] = static_cast<std::uint8_t>(changed >> 8U);
  bytes[5] = static_cast<std::uint8_t>(changed);
  const std::uint32_t crc = spindle_twin::firmware::crc32(bytes);
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(crc >> shift));
  bytes.insert(bytes.end(), behind.begin(), behind.end());
  bytes.resize(std::min(bytes.size(), max_size));
  std::copy(bytes.begin(), bytes.end(), data);
  return bytes.size();
}

// Feeds a fuzzer's check with changed files of its corpus, without libFuzzer and its counters: for the build of the
// tests under GCC's sanitizers.   short_fuzz_READER --seconds S [--seed N] [--most-bytes N] CORPUS Prints seed and
// executions. A finding ends it; the input stands in short_fuzz_finding.
#include <sanitizer/common_interface_defs.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
extern "C" __attribute__((weak)) std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                                                     std::size_t max_size, unsigned seed);

namespace {

using Bytes = std::vector<std::uint8_t>;

struct State {
  std::mt19937 random;
  std::vector<Bytes> pool;
  Bytes input;  ///< what is being tried
};
State& state() {
  static State the_state;
  return the_state;
}

std::size_t below(std::size_t end) { return end == 0 ? 0 : state().random() % end; }

void keep_finding() {
  std::ofstream file("short_fuzz_finding", std::ios::binary);
  file.write(reinterpret_cast<const char*>(state().input.data()), static_cast<std::streamsize>(state().input.size()));
  std::fprintf(stderr, "the input is in %s\n", std::filesystem::absolute("short_fuzz_finding").c_str());
}

void insert_piece(Bytes& bytes, std::size_t room) {
  const Bytes& from = below(2) == 0 || state().pool.empty() ? bytes : state().pool[below(state().pool.size())];
  if (from.empty() || room == 0) return;
  const std::size_t at = below(from.size());
  const std::size_t count = std::min({room, from.size() - at, std::size_t{1} << below(9)});
  const Bytes piece(from.begin() + static_cast<std::ptrdiff_t>(at),
                    from.begin() + static_cast<std::ptrdiff_t>(at + count));
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size() + 1)), piece.begin(), piece.end());
}

void erase_piece(Bytes& bytes) {
  const std::size_t at = below(bytes.size());
  const std::size_t count = std::min(bytes.size() - at, std::size_t{1} << below(9));
  bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.begin() + static_cast<std::ptrdiff_t>(at + count));
}

/// A number of the text, if there is one behind `at`, gets another digit; else a byte another value.
void change_digit(Bytes& bytes) {
  const auto from = bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size()));
  const auto digit = std::find_if(from, bytes.end(), [](std::uint8_t byte) { return byte >= '0' && byte <= '9'; });
  static constexpr std::string_view others = "0123456789.-e";
  if (digit != bytes.end()) *digit = static_cast<std::uint8_t>(others[below(others.size())]);
}

void change_byte(Bytes& bytes) {
  static constexpr std::array<std::uint8_t, 8> odd{0x00, 0x01, 0x7F, 0x80, 0xFF, 0xFE, 0x20, 0x0A};
  std::uint8_t& byte = bytes[below(bytes.size())];
  byte = below(2) == 0 ? odd[below(odd.size())] : static_cast<std::uint8_t>(byte ^ (1U << below(8)));
}

Bytes read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Changes one input of the pool, tries it, and may put it into the pool.
void try_one(std::size_t most_bytes) {
  constexpr std::size_t corpus_and_more = 512;
  State& now = state();
  Bytes input = now.pool[below(now.pool.size())];
  std::size_t size = std::min(input.size(), most_bytes);
  input.resize(most_bytes);
  for (std::size_t n = 1 + below(4); n > 0; --n) {
    size = LLVMFuzzerCustomMutator != nullptr
               ? LLVMFuzzerCustomMutator(input.data(), size, most_bytes, static_cast<unsigned>(now.random()))
               : LLVMFuzzerMutate(input.data(), size, most_bytes);
  }
  input.resize(size);
  now.input = std::move(input);
  LLVMFuzzerTestOneInput(now.input.data(), now.input.size());
  if (below(64) != 0) return;
  if (now.pool.size() < corpus_and_more)
    now.pool.push_back(now.input);
  else
    now.pool[below(now.pool.size())] = now.input;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size) {
  Bytes bytes(data, data + size);
  const std::size_t room = max_size - size;
  switch (bytes.empty() ? 3 : below(5)) {
    case 0:
      change_byte(bytes);
      break;
    case 1:
      change_digit(bytes);
      break;
    case 2:
      erase_piece(bytes);
      break;
    case 3:
      insert_piece(bytes, room);
      break;
    default:
      bytes.resize(below(bytes.size() + 1));
  }
  if (bytes.empty() && max_size > 0) bytes.push_back(static_cast<std::uint8_t>(below(256)));
  std::copy(bytes.begin(), bytes.end(), data);
  return bytes.size();
}

int main(int count, char** arguments) {
  double seconds = 10.0;
  unsigned seed = 1;
  std::size_t most_bytes = 5000;
  for (int a = 1; a < count; ++a) {
    const std::string_view word = arguments[a];
    const bool has_value = a + 1 < count;
    if (word == "--seconds" && has_value)
      seconds = std::atof(arguments[++a]);
    else if (word == "--seed" && has_value)
      seed = static_cast<unsigned>(std::atoi(arguments[++a]));
    else if (word == "--most-bytes" && has_value)
      most_bytes = static_cast<std::size_t>(std::atoi(arguments[++a]));
    else {
      for (const auto& file : std::filesystem::directory_iterator(word)) state().pool.push_back(read_file(file.path()));
    }
  }
  if (state().pool.empty()) {
    std::fprintf(stderr, "no corpus\n");
    return 2;
  }
  std::sort(state().pool.begin(), state().pool.end());
  state().random.seed(seed);
  __sanitizer_set_death_callback(keep_finding);
  std::printf("seed %u\n", seed);
  std::fflush(stdout);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  std::size_t executions = 0;
  try {
    for (; std::chrono::steady_clock::now() < end; ++executions) try_one(most_bytes);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "execution %zu: %s\n", executions, error.what());
    keep_finding();
    return 1;
  }
  std::printf("%zu executions\n", executions);
  return 0;
}

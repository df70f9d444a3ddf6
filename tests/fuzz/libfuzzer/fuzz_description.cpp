#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/check_description.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spindle_twin::fem_offline::checked(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}

namespace {

struct Token {
  std::size_t at, length;
};

std::vector<Token> numbers_in(const std::string& text) {
  std::vector<Token> found;
  for (std::size_t i = 0; i < text.size();) {
    const bool starts = text[i] >= '0' && text[i] <= '9' && i > 0 &&
                        (text[i - 1] == ' ' || text[i - 1] == '[' || text[i - 1] == '-' || text[i - 1] == '=');
    if (!starts) {
      ++i;
      continue;
    }
    const std::size_t end = std::min(text.find_first_not_of("0123456789.e", i), text.size());
    found.push_back({i, end - i});
    i = end;
  }
  return found;
}

}  // namespace

/// Bytes changed at random hardly ever leave valid TOML: half of the changes replace one number of the text by another.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  std::mt19937 random(seed);
  std::string text(reinterpret_cast<const char*>(data), size);
  const auto numbers = numbers_in(text);
  if (numbers.empty() || random() % 4 == 0) return LLVMFuzzerMutate(data, size, max_size);
  const auto replace_one = [&] {
    const auto all = numbers_in(text);
    const Token& one = all[random() % all.size()];
    const Token& other = all[random() % all.size()];
    static const std::vector<std::string> odd = {"0",    "1",    "-1",  "1e-7",        "1e-6",      "2e-6",
                                                 "1e-4", "1e-3", "0.5", "1e5",         "1e9",       "1e300",
                                                 "inf",  "nan",  "20",  "40.00000149", "19.9999995"};
    std::string with;
    switch (random() % 4) {
      case 0:
        with = odd[random() % odd.size()];
        break;
      case 1:
        with = text.substr(other.at, other.length);
        break;
      case 2:
        with =
            text.substr(one.at, one.length) + (text.substr(one.at, one.length).find('.') < one.length ? "1" : ".001");
        break;
      default:
        with = std::to_string(random() % 120);
    }
    text.replace(one.at, one.length, with);
  };
  for (unsigned count = 1 + random() % 3; count > 0; --count) {
    if (numbers_in(text).empty()) break;
    replace_one();
  }
  if (text.size() > max_size) text.resize(max_size);
  std::copy(text.begin(), text.end(), data);
  return text.size();
}

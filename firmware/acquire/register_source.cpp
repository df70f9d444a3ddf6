#include "firmware/acquire/register_source.hpp"

#include <bit>

namespace spindle_twin::firmware {

double decode(const RegisterSource& source, std::span<const std::uint16_t> words) {
  const std::uint32_t first = words[0];
  const std::uint32_t second = words_of(source.type) == 2 ? words[1] : 0U;
  double count = 0.0;
  switch (source.type) {
    case RegisterType::uint16:
      count = first;
      break;
    case RegisterType::int16:
      count = static_cast<std::int16_t>(words[0]);
      break;
    case RegisterType::offset16:
      count = static_cast<double>(first) - 32768.0;
      break;
    case RegisterType::uint32:
      count = (first << 16U) | second;
      break;
    case RegisterType::int32:
      count = static_cast<std::int32_t>((first << 16U) | second);
      break;
    case RegisterType::float32:
      count = static_cast<double>(std::bit_cast<float>((first << 16U) | second));
      break;
    case RegisterType::float32_cdab:
      count = static_cast<double>(std::bit_cast<float>((second << 16U) | first));
      break;
  }
  return count;
}

}  // namespace spindle_twin::firmware

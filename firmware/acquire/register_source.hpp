#pragma once

#include <cstdint>
#include <span>

#include "firmware/words/register_type.hpp"

namespace spindle_twin::firmware {

enum class RegisterTable { input, holding };

/// Where a number stands in a Modbus device.
struct RegisterSource {
  RegisterTable table = RegisterTable::input;
  std::uint16_t address = 0;  ///< 0-based
  RegisterType type = RegisterType::int16;
};

/// The number in `words`, which start at the source's address. float32 NaN stays NaN.
double decode(const RegisterSource& source, std::span<const std::uint16_t> words);

}  // namespace spindle_twin::firmware

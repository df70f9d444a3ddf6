#pragma once

#include <optional>
#include <string_view>

namespace spindle_twin::firmware {

/// How a number stands in Modbus registers of 16 bits. offset16: int16 + 32768. 32 bits are two words, the high one
/// first (ABCD); of cdab the low one.
enum class RegisterType { uint16, int16, offset16, uint32, int32, float32, float32_cdab };

/// "int16", "float32_cdab", ...
const char* register_type_name(RegisterType type);
/// The type of such a name; empty: there is none.
std::optional<RegisterType> register_type_of(std::string_view name);

/// 1 or 2.
int words_of(RegisterType type);

}  // namespace spindle_twin::firmware

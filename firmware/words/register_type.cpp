#include "firmware/words/register_type.hpp"

namespace spindle_twin::firmware {

int words_of(RegisterType type) {
  switch (type) {
    case RegisterType::uint16:
    case RegisterType::int16:
    case RegisterType::offset16:
      return 1;
    default:
      return 2;
  }
}

const char* register_type_name(RegisterType type) {
  switch (type) {
    case RegisterType::uint16:
      return "uint16";
    case RegisterType::int16:
      return "int16";
    case RegisterType::offset16:
      return "offset16";
    case RegisterType::uint32:
      return "uint32";
    case RegisterType::int32:
      return "int32";
    case RegisterType::float32:
      return "float32";
    case RegisterType::float32_cdab:
      return "float32_cdab";
  }
  return "";
}

std::optional<RegisterType> register_type_of(std::string_view name) {
  for (const RegisterType type :
       {RegisterType::uint16, RegisterType::int16, RegisterType::offset16, RegisterType::uint32, RegisterType::int32,
        RegisterType::float32, RegisterType::float32_cdab}) {
    if (name == register_type_name(type)) return type;
  }
  return std::nullopt;
}

}  // namespace spindle_twin::firmware

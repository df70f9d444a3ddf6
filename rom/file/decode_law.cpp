#include "rom/file/decode_law.hpp"

#include <stdexcept>

#include "rom/file/decode_fields.hpp"

namespace spindle_twin::rom {
namespace {

bool decode_law_number(pb_istream_t* stream, NamedNumber& item) {
  spindle_twin_rom_LawNumber message = spindle_twin_rom_LawNumber_init_zero;
  message.name = attach(item.name);
  if (!pb_decode(stream, spindle_twin_rom_LawNumber_fields, &message)) return false;
  item.value = message.value;
  return true;
}

LawTemperature temperature_of(const spindle_twin_rom_LawTemperature& message) {
  return {message.part, message.environment, message.nominal_K};
}

}  // namespace

void attach_physics(spindle_twin_rom_PhysicalLaw& message, DecodedLaw& decoded) {
  message.kind = attach(decoded.kind);
  message.numbers = attach_list<NamedNumber, decode_law_number>(decoded.numbers);
}

std::optional<BoundLaw> decode_physics(const spindle_twin_rom_PhysicalLaw& message, const DecodedLaw& decoded,
                                       std::string& fault) {
  BoundLaw physics;
  try {
    physics.law.parameters = law_from_numbers(decoded.kind, decoded.numbers);
  } catch (const std::invalid_argument& error) {
    fault = error.what();
    return std::nullopt;
  }
  if (message.mode >= law_modes.size() || !message.has_first || !message.has_second) {
    fault = "its mode does not exist, or its temperatures are missing";
    return std::nullopt;
  }
  physics.law.mode = static_cast<LawMode>(message.mode);
  physics.first = temperature_of(message.first);
  physics.second = temperature_of(message.second);
  physics.pressure = message.pressure;
  physics.displacement = message.displacement;
  physics.displacement_sign = message.displacement_sign;
  physics.nominal_pressure_Pa = message.nominal_pressure_Pa;
  physics.nominal_displacement_m = message.nominal_displacement_m;
  physics.circuit = message.circuit;
  return physics;
}

}  // namespace spindle_twin::rom

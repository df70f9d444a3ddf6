#pragma once

#include <cstdint>

#include "firmware/serve/register_map.hpp"

namespace spindle_twin::firmware {

/// Writes `value` (in the register's unit) into slot `slot` of `which`:
///   count = round(value / resolution), clipped to the type's range without its not-present value;
///   32 bits go as two words, high word first (ABCD) or low word first (cdab); float32 is value / resolution as it is.
/// NaN writes not present. Returns false if the value was clipped.
/// The words are packed here because the float setters of libmodbus 3.1.6 swap bytes (modbus_set_float_abcd(-12.5)
/// gives 48C1 0000 instead of C148 0000).
bool put(RegisterImage& image, Register which, double value, int slot = 0);

void put_not_present(RegisterImage& image, Register which, int slot = 0);

/// The value of a slot in the register's unit, NaN for not present: the inverse of put().
double get(const RegisterImage& image, Register which, int slot = 0);

}  // namespace spindle_twin::firmware

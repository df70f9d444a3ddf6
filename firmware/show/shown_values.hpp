#pragma once

#include <string>
#include <vector>

#include "firmware/serve/register_map.hpp"
#include "firmware/show/shown_names.hpp"

namespace spindle_twin::firmware {

/// One number of a spindle, as everything that is no register shows it.
struct ShownValue {
  Register which;
  int slot;                      ///< of the register
  const std::string* slot_name;  ///< by the network; null: the slots have no names
  const CodeName* bit;           ///< the number is this bit of the register, 0 or 1; null: the register's own
};

/// The numbers of one register, slot by slot and bit by bit, as many as `names` has; it must outlive them. Allocates.
std::vector<ShownValue> shown_values(Register which, const ShownNames& names);

/// "nose_float32" is "nose": the register in another form has the same name elsewhere.
std::string shown_name(const RegisterEntry& entry);

/// Whether a register is shown elsewhere by number: neither an order nor one that only repeats another.
bool is_shown(const RegisterEntry& entry);

/// The value of a slot in its unit; NaN: not present. The heartbeat uses all 16 bits and is always present.
double shown_value(const RegisterImage& image, Register which, int slot);
double shown_value(const RegisterImage& image, const ShownValue& value);

}  // namespace spindle_twin::firmware

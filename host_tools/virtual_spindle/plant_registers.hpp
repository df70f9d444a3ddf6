#pragma once

#include <array>
#include <cstdint>

#include "host_tools/virtual_spindle/plant_truth.hpp"

/// The register map of the simulated data-acquisition device, the same on function codes 3 and 4, offsets from 0.
/// 16-bit values are what a temperature module shows; float32 values have the high word first (ABCD).
/// int16 temperatures: 0.01 degC, -32768 = not fitted.
///
///   0        known answer 0x1234
///   1        1 = simulated
///   2        sequence, +1 per model step
///   3        number of temperature channels
///   4        speed, 1 rpm, magnitude
///   5        load, 0.1 %
///   6, 7     coolant inlet, ambient, 0.01 degC
///   8-23     temperature channels 1-16, 0.01 degC
///   24-27    flow of coolant circuits 1-4, 0.1 g/s, negative backwards, -32768 = no such circuit
///   28, 29   motor current, 0.01 A; motor power, 10 W, negative when it brakes; -32768 = not in the schedule
///   30       model time, s (float32); 32 speed, rpm; 34 load, 1 = rated; 36, 38 coolant inlet, ambient, degC
///   40-71    temperature channels 1-16, degC (float32)
/// Truth, for whoever judges a twin and for nobody else (float32):
///   100      model time, s
///   102-109  deformation outputs 1-4, um
///   110-141  key points without noise and offset, degC
///   142-205  part maxima 1-32, degC
namespace spindle_twin::host_tools {

constexpr int plant_register_count = 206;
using PlantRegisters = std::array<std::uint16_t, plant_register_count>;

PlantRegisters encode_plant(const rom::Boundaries& boundaries, const PlantSnapshot& snapshot);

}  // namespace spindle_twin::host_tools

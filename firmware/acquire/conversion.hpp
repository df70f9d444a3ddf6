#pragma once

namespace spindle_twin::firmware {

/// Resistance of an industrial platinum thermometer of 100 ohm (IEC 60751: Callendar-Van Dusen), -200 to 850 degC.
double pt100_ohm(double temperature_degC);
/// The temperature of that resistance, 18.52 to 390.481 ohm; to 1e-6 K the inverse of pt100_ohm().
double pt100_degC(double resistance_ohm);

/// What the wire of a channel says besides its value.
enum class WireFault {
  none,
  under,    ///< below the range, as far as a healthy transmitter goes: the value is the range's end
  over,     ///< likewise above
  shorted,  ///< resistance too small, or current of at most 3.6 mA (NAMUR NE 43: failure or broken wire)
  open,     ///< resistance too large, or current of at least 21 mA
};

/// "under", "open", ...
const char* wire_fault_name(WireFault fault);

/// To SI: x_SI = x * factor + shift.
struct Unit {
  double factor = 1.0;
  double shift = 0.0;
};

enum class ConversionKind { linear, pt100, ma_4_20 };

/// How a device's number becomes a value in SI.
struct Conversion {
  ConversionKind kind = ConversionKind::linear;
  double scale = 1.0;  ///< number * scale + offset is in the channel's unit, in ohm or in mA
  double offset = 0.0;
  double at_4mA = 0.0;  ///< channel's unit
  double at_20mA = 0.0;
  Unit unit;  ///< from the channel's unit
};

struct Converted {
  double value = 0.0;  ///< SI; NaN: the device or the current tells none
  WireFault fault = WireFault::none;
};

/// Limits of a current after NAMUR NE 43: 3.8 to 20.5 mA are measured values, to 3.6 and 21 mA the value is held at
/// these ends (under, over), beyond there is none. A resistance is judged by the same shares of its span: -200 and
/// 850 degC are the ends (under, over), from 2.5 % below and 6.25 % above it on the thermometer is shorted or open; the
/// value is the end's, as a thermometer's electronics would show it. May run in the cycle.
Converted convert(const Conversion& conversion, double number);

/// One step of the device's number in the channel's unit; for resolutions.
double step_of(const Conversion& conversion);

}  // namespace spindle_twin::firmware

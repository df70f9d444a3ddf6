#pragma once

#include <cstddef>

namespace spindle_twin::fem_offline {

/// sRGB, 0 to 1.
struct Colour {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
  double opacity = 1.0;
};

inline constexpr Colour white{1.0, 1.0, 1.0, 1.0};

/// Oklab lightness (0 black to 1 white), chroma and hue to sRGB, chroma reduced until the colour exists.
/// Source: B. Ottosson, "A perceptual color space for image processing" (2020).
Colour from_oklch(double lightness, double chroma, double hue_degrees);

/// Oklab lightness of an sRGB colour.
double lightness_of(const Colour& colour);

/// Colour map for fields, share 0 to 1 (clamped): indigo over teal to yellow. Five control points of hue and chroma in
/// Oklab; lightness is linear in the share, so that equal steps of the field look equally far apart, also in grey.
Colour field_colour(double share);

/// Pale colours that differ for neighbours in the list of parts.
Colour part_colour(std::size_t part);

}  // namespace spindle_twin::fem_offline

#pragma once

#include <cairo.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "fem_offline/look/picture_canvas.hpp"

namespace spindle_twin::fem_offline {

/// A PNG read back.
struct Image {
  explicit Image(const std::string& path)
      : surface(cairo_image_surface_create_from_png(path.c_str()), cairo_surface_destroy) {}
  int width() const { return cairo_image_surface_get_width(surface.get()); }
  int height() const { return cairo_image_surface_get_height(surface.get()); }
  Colour at(const Pixel& place) const {
    const unsigned char* row = cairo_image_surface_get_data(surface.get()) +
                               static_cast<std::ptrdiff_t>(place.y) * cairo_image_surface_get_stride(surface.get());
    const auto value = reinterpret_cast<const std::uint32_t*>(row)[static_cast<std::size_t>(place.x)];
    const auto share = [&](int shift) { return static_cast<double>(value >> shift & 0xffU) / 255.0; };
    return {share(16), share(8), share(0), 1.0};
  }
  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface;
};

}  // namespace spindle_twin::fem_offline

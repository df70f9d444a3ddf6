#include "fem_offline/look/section_outlines.hpp"

namespace spindle_twin::fem_offline {
namespace {

rom::OutlineRing ring_of(const std::string& part, const Polygon& polygon) {
  rom::OutlineRing ring{part, Eigen::MatrixXd(2, static_cast<Eigen::Index>(polygon.size()))};
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    ring.points_m.col(static_cast<Eigen::Index>(i)) << polygon[i].r_m, polygon[i].z_m;
  }
  return ring;
}

}  // namespace

std::vector<rom::OutlineRing> section_outlines(const Spindle& spindle, const Section& section) {
  std::vector<rom::OutlineRing> rings;
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    for (const OutlineFace& face : section.outlines[part].faces) {
      rings.push_back(ring_of(spindle.parts[part].name, face.outer));
      for (const Polygon& hole : face.holes) rings.push_back(ring_of(spindle.parts[part].name, hole));
    }
  }
  return rings;
}

}  // namespace spindle_twin::fem_offline

#include <mutex>

#include "tests/bench/campaign/models.hpp"
#include "tests/bench/reality/truth.hpp"

namespace spindle_twin::bench {
namespace {

constexpr double displaced_m = 0.010;
constexpr double cutting_W = 25.0;
constexpr std::uint32_t structure_purpose = 11;

void add_places(fem_offline::Spindle& spindle) {
  for (std::size_t s = 0; s < sensor_count; ++s) {
    for (const double direction : {-1.0, 1.0}) {
      fem_offline::KeyPoint point = spindle.key_points[s];
      point.name += direction < 0.0 ? "_forward" : "_backward";
      point.at.z_m += direction * displaced_m;
      spindle.key_points.push_back(point);
    }
  }
}

void change_structure(TruthKind kind, std::uint64_t seed, fem_offline::Spindle& spindle) {
  std::mt19937_64 random = random_of(seed, structure_purpose);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto factor = [&] {
    const double sign = unit(random) < 0.5 ? -1.0 : 1.0;
    return 1.0 + sign * (0.1 + 0.1 * unit(random));
  };
  for (fem_offline::Material& material : spindle.materials) {
    const bool exact = kind == TruthKind::structure_10;
    const double conductivity = exact ? 0.9 : factor();
    material.conductivity_r_W_per_mK *= conductivity;
    material.conductivity_z_W_per_mK *= conductivity;
    material.heat_capacity_J_per_kgK *= exact ? 1.1 : factor();
    material.expansion_per_K *= exact ? 1.1 : factor();
  }
}

}  // namespace

fem_offline::FeModel truth_model(TruthKind kind, std::uint64_t seed, double element_size_mm) {
  static std::mutex meshing;  // the mesher has one state for the whole program
  const std::lock_guard lock(meshing);
  constexpr double coarse_mm = 12.0;  // of a model that is made for its description only
  static const fem_offline::Spindle described = model_of(coarse_mm).description();
  fem_offline::Spindle spindle = described;
  spindle.mesh.element_size_m = 1e-3 * element_size_mm;
  add_places(spindle);
  add_cutting_heat(spindle, cutting_W);
  if (kind == TruthKind::structure || kind == TruthKind::structure_10) change_structure(kind, seed, spindle);
  return {spindle, fem_offline::build_section(spindle)};
}

}  // namespace spindle_twin::bench

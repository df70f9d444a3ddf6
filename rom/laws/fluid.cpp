#include "rom/laws/fluid.hpp"

namespace spindle_twin::rom {

Lubricant lubricant_through(double first_K, double first_m2_per_s, double second_K, double second_m2_per_s) {
  const auto lglg = [](double viscosity_m2_per_s) { return std::log10(std::log10(viscosity_m2_per_s * 1e6 + 0.7)); };
  Lubricant oil;
  oil.walther_b = (lglg(first_m2_per_s) - lglg(second_m2_per_s)) / (std::log10(second_K) - std::log10(first_K));
  oil.walther_a = lglg(first_m2_per_s) + oil.walther_b * std::log10(first_K);
  return oil;
}

}  // namespace spindle_twin::rom

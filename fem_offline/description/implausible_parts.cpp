#include "fem_offline/description/implausible_parts.hpp"

#include <string>

#include "fem_offline/description/read_tables.hpp"
#include "rom/range.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

using rom::between;
using rom::Range;

constexpr Range conductivity_W_per_mK = between(0.01, 2500.0);
constexpr Range density_kg_per_m3 = between(0.1, 2.5e4);
constexpr Range heat_capacity_J_per_kgK = between(50.0, 6000.0);
constexpr Range youngs_modulus_Pa = between(1e6, 1.3e12);
constexpr Range expansion_per_K = between(0.0, 5e-4);
constexpr Range strain_free_degC = between(-40.0, 100.0);
constexpr Range preload_Pa = between(0.0, 5e9);
constexpr double most_interference = 0.01;  // of the radius

struct Judged {
  std::vector<ImplausibleValue> found;

  void value(const rom::SourceLine& where, const std::string& field, double value, Range believed,
             const std::string& unit) {
    if (auto amiss = rom::judge_value(value, believed, field, unit)) found.push_back({where, std::move(*amiss)});
  }
};

void judge_material(const Material& material, bool grows, Judged& judged) {
  const auto judge = [&](const char* key, double value, Range believed, const char* unit) {
    judged.value(material.where, "material " + material.name + ": " + key, value, believed, unit);
  };
  judge("conductivity_r_W_per_mK", material.conductivity_r_W_per_mK, conductivity_W_per_mK, "W/mK");
  judge("conductivity_z_W_per_mK", material.conductivity_z_W_per_mK, conductivity_W_per_mK, "W/mK");
  judge("density_kg_per_m3", material.density_kg_per_m3, density_kg_per_m3, "kg/m3");
  judge("heat_capacity_J_per_kgK", material.heat_capacity_J_per_kgK, heat_capacity_J_per_kgK, "J/kgK");
  if (!grows) return;
  judge("youngs_modulus_Pa", material.youngs_modulus_Pa, youngs_modulus_Pa, "Pa, not GPa");
  judge("expansion_per_K", material.expansion_per_K, expansion_per_K, "1/K, 1.2e-5 for steel");
}

void judge_joint(const Spindle& spindle, const Contact& contact, Judged& judged) {
  const std::string name = spindle.parts[contact.part_a].name + "-" + spindle.parts[contact.part_b].name + ": ";
  if (contact.preload_pressure_Pa) {
    judged.value(contact.where, name + "preload_pressure_Pa", *contact.preload_pressure_Pa, preload_Pa, "Pa");
  }
  if (!contact.fit) return;
  judged.value(contact.where, name + "interference_um", contact.fit->interference_m / rom::m_per_um,
               between(0.0, most_interference * contact.fit->fit_radius_m / rom::m_per_um),
               "um of radius, beyond which every metal yields");
}

}  // namespace

std::vector<ImplausibleValue> implausible_parts(const Spindle& spindle) {
  Judged judged;
  const bool grows = !spindle.deformations.empty() || !spindle.contact_pressures.empty();
  for (const Material& material : spindle.materials) judge_material(material, grows, judged);
  if (!grows) return judged.found;
  judged.value(spindle.operating.where, "operating: reference_temperature_degC",
               spindle.operating.reference_temperature_K - rom::zero_degC_K, strain_free_degC, "degC, not kelvin");
  for (const Contact& contact : spindle.contacts) judge_joint(spindle, contact, judged);
  return judged.found;
}

}  // namespace spindle_twin::fem_offline

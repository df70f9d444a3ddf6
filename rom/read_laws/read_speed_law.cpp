#include "rom/read_laws/read_speed_law.hpp"

#include <cmath>
#include <sstream>

namespace spindle_twin::rom {

SpeedLaw read_speed_law(const TomlTable& owner) {
  SpeedLaw law;
  const auto table = owner.optional_table("speed_law");
  if (!table) return law;
  law.constant = table->number_or("constant", 0.0, not_negative);
  for (const auto& row : table->rows_or_empty("speed_terms", 2, not_negative))
    law.speed_terms.push_back({row[0], row[1]});
  law.load_squared = table->number_or("load_squared", 0.0, not_negative);
  law.zero_at_standstill = table->boolean_or("zero_at_standstill", false);
  double sum = law.constant + law.load_squared;
  for (const auto& term : law.speed_terms) sum += term.coefficient;
  if (std::abs(sum - 1.0) > 1e-9) {
    std::ostringstream text;
    text << "constant, coefficients and load_squared must add up to 1, the value at reference speed and full load; "
            "they make "
         << sum;
    owner.fail("speed_law", text.str());
  }
  return law;
}

bool read_friction(const TomlTable& heat, const SpeedLaw& law) {
  return heat.boolean_or("friction", is_friction_unless_said(law));
}

}  // namespace spindle_twin::rom

#include <algorithm>
#include <filesystem>

#include "fem_offline/description/read_tables.hpp"

namespace spindle_twin::fem_offline {
namespace {

using rom::positive;

constexpr double temperature_tolerance = 1e-4;
constexpr double other_tolerance = 1e-3;

template <typename Item>
bool any_named(const std::vector<Item>& items, const std::string& name) {
  return std::any_of(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
}

bool any_contact(const Spindle& spindle, const std::string& name) {
  return std::any_of(spindle.contacts.begin(), spindle.contacts.end(), [&](const Contact& contact) {
    return spindle.parts[contact.part_a].name + "/" + spindle.parts[contact.part_b].name == name;
  });
}

bool exists(const Spindle& spindle, const std::string& quantity, const std::string& name) {
  if (quantity == "temperature_degC") return any_named(spindle.key_points, name);
  if (quantity == "deformation_um") return any_named(spindle.deformations, name);
  if (quantity.starts_with("stress_")) return any_named(spindle.stress_probes, name);
  // A coolant segment's heat counts from the coolant's temperature there, which no case needs so far.
  for (const CoolantCircuit& circuit : spindle.circuits) {
    for (const std::size_t film : circuit.segments) {
      if (spindle.films[film].name == name) return false;
    }
  }
  return any_named(spindle.films, name) || any_named(spindle.gap_films, name) || any_contact(spindle, name);
}

Expectation read_expectation(const TomlTable& table, const Spindle& spindle) {
  Expectation expected;
  expected.where = table.where("quantity");
  expected.quantity = table.choice("quantity", {"temperature_degC", "deformation_um", "heat_W", "flux_W_per_m2",
                                                "stress_rr_MPa", "stress_zz_MPa", "stress_tt_MPa", "stress_rz_MPa"});
  expected.of = table.string("of");
  if (!exists(spindle, expected.quantity, expected.of)) {
    table.fail("of", "there is no \"" + expected.of + "\" with a " + expected.quantity +
                         ": key points have temperatures, deformation outputs deformations, stress probes stresses, "
                         "films and gap films by name and contacts by \"part_a/part_b\" heats and fluxes");
  }
  expected.time_s = table.optional_number("time_s", positive);
  expected.target = table.number("target");
  const bool is_temperature = expected.quantity == "temperature_degC";
  expected.tolerance = table.number_or("tolerance", is_temperature ? temperature_tolerance : other_tolerance, positive);
  if (!is_temperature && expected.target == 0.0) table.fail("target", "must not be 0: the tolerance is a part of it");
  expected.source = table.string("source");
  return expected;
}

}  // namespace

void read_verification(const TomlTable& root, Spindle& spindle) {
  const auto table = root.optional_table("verification");
  const auto expectations = root.tables_or_empty("expect");
  if (!table) {
    if (!expectations.empty()) expectations[0].fail("quantity", "a description with expectations needs [verification]");
    return;
  }
  Verification verification;
  verification.proves = table->string("proves");
  verification.temperature_span_K = table->number("temperature_span_K", positive);
  if (const auto schedule = table->optional_string("schedule")) {
    verification.schedule = (std::filesystem::path(spindle.file).parent_path() / *schedule).string();
  }
  verification.max_step_s = table->number_or("max_step_s", verification.max_step_s, positive);
  for (const auto& expected : expectations) {
    verification.expectations.push_back(read_expectation(expected, spindle));
  }
  spindle.verification = std::move(verification);
}

}  // namespace spindle_twin::fem_offline

#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "fem_offline/exchange_files/deck_model.hpp"

/// What tests of decks start from.
namespace spindle_twin::fem_offline::exchange_files_test {

inline const std::string spindles = SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/";

/// 1, 2, 3 ... W, the description's own coefficients, and 100 W/K in every circuit in the sense of its flow.
inline rom::BoundaryValues values_of(const Spindle& spindle) {
  rom::BoundaryValues values;
  std::vector<double> conductances;
  for (const Contact& contact : spindle.contacts) conductances.push_back(contact.conductance_W_per_m2K);
  for (const GapFilm& gap : spindle.gap_films) conductances.push_back(gap.coefficient_W_per_m2K);
  for (const Film& film : spindle.films) conductances.push_back(film.coefficient_W_per_m2K);
  values.conductance_W_per_m2K =
      Eigen::Map<Eigen::VectorXd>(conductances.data(), static_cast<Eigen::Index>(conductances.size()));
  const auto heats = static_cast<Eigen::Index>(spindle.heats.size());
  values.heat_W = Eigen::VectorXd::LinSpaced(heats, 1.0, static_cast<double>(heats));
  values.coolant_W_per_K.resize(static_cast<Eigen::Index>(spindle.circuits.size()));
  for (std::size_t c = 0; c < spindle.circuits.size(); ++c) {
    values.coolant_W_per_K[static_cast<Eigen::Index>(c)] = spindle.circuits[c].flow_kg_per_s < 0.0 ? -100.0 : 100.0;
  }
  return values;
}

/// Fluid i stays at 300 + i K.
inline FluidHistory still_fluids(const DeckModel& deck) {
  FluidHistory history;
  for (std::size_t f = 0; f < deck.fluids.size(); ++f) history.steady_K.push_back(300.0 + static_cast<double>(f));
  history.time_s = {0.0, 1800.0};
  history.fluid_K = {history.steady_K, history.steady_K};
  return history;
}

inline std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

}  // namespace spindle_twin::fem_offline::exchange_files_test

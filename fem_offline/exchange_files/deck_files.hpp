#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "fem_offline/exchange_files/deck_model.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {

/// Decks are written in degC.
inline double degC(double temperature_K) { return temperature_K - rom::zero_degC_K; }

/// Names of CalculiX' sets: P part, M material, A and B the sides of a pair, G gap, I contact, V fluid.
inline std::string set_name(char letter, std::size_t number) {
  return std::string(1, letter).append(std::to_string(number));
}

/// Makes the folder. Throws rom::InputError if that is not possible.
void make_deck_folder(const std::string& directory);

/// A text file of a deck, numbers with 12 digits. Throws rom::InputError if it cannot be opened, or on close() if
/// something was not written.
class DeckFile {
 public:
  DeckFile(const std::string& directory, const std::string& name);
  void close();

  template <typename Item>
  DeckFile& operator<<(const Item& item) {
    stream_ << item;
    return *this;
  }

 private:
  std::string path_;
  std::ofstream stream_;
};

}  // namespace spindle_twin::fem_offline

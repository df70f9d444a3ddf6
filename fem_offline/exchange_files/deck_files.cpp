#include "fem_offline/exchange_files/deck_files.hpp"

#include <filesystem>
#include <iomanip>

namespace spindle_twin::fem_offline {

void make_deck_folder(const std::string& directory) {
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (failure) throw rom::InputError({directory, 0}, "", "no folder can be made: " + failure.message());
}

DeckFile::DeckFile(const std::string& directory, const std::string& name)
    : path_(directory + "/" + name), stream_(path_) {
  if (!stream_) throw rom::InputError({path_, 0}, "", "cannot be opened for writing");
  stream_ << std::setprecision(12) << std::showpoint;  // FreeFEM reads a number without a point as a short integer
}

void DeckFile::close() {
  stream_.close();
  if (!stream_) throw rom::InputError({path_, 0}, "", "cannot be written");
}

}  // namespace spindle_twin::fem_offline

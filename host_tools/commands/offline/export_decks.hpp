#pragma once

#include <string>

namespace spindle_twin::host_tools {

/// Writes the FE model of a description as decks for CalculiX and FreeFEM into these folders; an empty one is left out.
/// Laws are held at their nominal inputs, arcs are chords. Throws rom::InputError for a bad description and for what
/// decks cannot hold (fem_offline/exchange_files).
void export_decks(const std::string& spindle_path, const std::string& calculix_directory,
                  const std::string& freefem_directory);

}  // namespace spindle_twin::host_tools

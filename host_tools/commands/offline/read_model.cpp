#include "host_tools/commands/offline/read_model.hpp"

#include <algorithm>

#include "fem_offline/description/implausible_parts.hpp"
#include "fem_offline/description/model_places.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

/// Films, contacts and heats. Not the films that hold a prescribed temperature: they are as good as the mesh asks for.
void note_boundaries(const fem_offline::FeModel& model, const std::string& spindle_path, Plausibility& plausibility) {
  const fem_offline::AffineModel& affine = model.affine();
  const auto is_held = [&](std::size_t conductance) {
    return std::find(affine.held.begin(), affine.held.end(), static_cast<int>(conductance)) != affine.held.end();
  };
  for (const rom::Implausible& what : rom::implausible_description(affine.boundaries, affine.capacity_J_per_K.sum())) {
    if (!what.conductance) {
      plausibility.note({spindle_path, 0}, {what});
    } else if (!is_held(*what.conductance)) {
      plausibility.note(where_of_conductance(model.description(), *what.conductance), {what});
    }
  }
}

}  // namespace

fem_offline::FeModel read_model(const std::string& spindle_path, Plausibility& plausibility) {
  if (rom::is_rom_file(spindle_path)) {
    throw rom::InputError({spindle_path, 0}, "",
                          "is a network file, for `inspect`, `simulate` and the daemon; here the TOML description is "
                          "wanted that it was built from");
  }
  if (rom::is_by_hand(spindle_path)) {
    throw rom::InputError({spindle_path, 0}, "node",
                          "this is a network written by hand, for `spindle-twin assemble`, which has no FE model");
  }
  fem_offline::FeModel model = fem_offline::build_fe_model(spindle_path);
  const fem_offline::AffineModel& affine = model.affine();
  if (!affine.imposed_rises_K) {
    for (const auto& [where, what] : fem_offline::implausible_parts(model.description())) {
      plausibility.note(where, {what});
    }
    note_boundaries(model, spindle_path, plausibility);
    plausibility.note({spindle_path, 0},
                      rom::implausible_inputs(affine.boundaries, rom::plausible_inputs(affine.boundaries),
                                              affine.boundaries.operating));
  }
  return model;
}

}  // namespace spindle_twin::host_tools

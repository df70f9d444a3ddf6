#include "host_tools/commands/offline/read_model.hpp"

#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {

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
    plausibility.note({spindle_path, 0},
                      rom::implausible_description(affine.boundaries, affine.capacity_J_per_K.sum()));
    plausibility.note({spindle_path, 0},
                      rom::implausible_inputs(affine.boundaries, rom::plausible_inputs(affine.boundaries),
                                              affine.boundaries.operating));
  }
  return model;
}

}  // namespace spindle_twin::host_tools

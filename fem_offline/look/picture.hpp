#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem_offline/look/picture_lattice.hpp"
#include "fem_offline/model/build_model.hpp"

namespace spindle_twin::fem_offline {

/// What a picture says of the field besides the field.
struct PictureState {
  std::string title;     ///< such as "steady state, 6000 rpm, load 1"
  double datum_K = 0.0;  ///< rises are counted from it
};

/// A value printed beside the place it belongs to.
struct NamedValue {
  std::string name;
  double value = 0.0;
};

/// Everything that the pictures of one state show.
struct SectionPicture {
  const Spindle& spindle;
  const Section& section;
  Lattice lattice;
  PictureState state;
  Eigen::VectorXd rises_K;  ///< one entry per node of the lattice
  std::vector<NamedValue> air_rises_K;
  std::vector<NamedValue> heats_W;  ///< of every source at the reference state
  std::vector<NamedValue> key_point_rises_K;
};

/// Draws the meridian section (z to the right, nose on the left, r upwards, mm) without a display, as PNG files
/// DIR/<name>_parts.png (every part with all that the description attaches to it) and DIR/<name>_rise.png. Returns
/// their paths. Throws rom::InputError if a file cannot be written. Mesh, displacements and stresses are in the VTU
/// (field_file.hpp).
std::vector<std::string> write_pictures(const std::string& directory, const std::string& name,
                                        const SectionPicture& picture);

/// Of a model, which must outlive it, in a field of temperatures (of all its unknowns).
SectionPicture picture_of(const FeModel& model, const Eigen::VectorXd& temperatures_K, const PictureState& state);

}  // namespace spindle_twin::fem_offline

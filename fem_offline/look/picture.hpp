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

/// Everything that the pictures of one state show. Fields hold one entry per node of the lattice, `displacements_m` two
/// (r, z); `deformation_um` has one entry per Spindle::deformations.
struct SectionPicture {
  const Spindle& spindle;
  const Section& section;
  const Lattice& lattice;
  PictureState state;
  Eigen::VectorXd rises_K;
  Eigen::VectorXd displacements_m;  ///< empty if the description asks for no mechanics
  Eigen::VectorXd von_mises_Pa;     ///< empty likewise
  std::vector<double> deformation_um;
  std::vector<NamedValue> air_rises_K;
  std::vector<NamedValue> heats_W;  ///< of every source at the reference state
  std::vector<NamedValue> key_point_rises_K;
  std::vector<PartQuality> quality;
};

/// Draws the meridian section (z to the right, nose on the left, r upwards, mm) without a display, as PNG files
/// DIR/<name>_parts.png, _rise.png, _mesh.png and, if the description asks for mechanics, _deformed.png and
/// _stress.png. Returns their paths. Throws rom::InputError if a file cannot be written.
std::vector<std::string> write_pictures(const std::string& directory, const std::string& name,
                                        const SectionPicture& picture);

/// The same of a model in a field of temperatures (of all its unknowns).
std::vector<std::string> write_pictures(const std::string& directory, const std::string& name, const FeModel& model,
                                        const Eigen::VectorXd& temperatures_K, const PictureState& state);

}  // namespace spindle_twin::fem_offline

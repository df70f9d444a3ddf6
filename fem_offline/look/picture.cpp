#include "fem_offline/look/picture.hpp"

#include "fem_offline/look/picture_frame.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {

std::vector<std::string> write_pictures(const std::string& directory, const std::string& name,
                                        const SectionPicture& picture) {
  const auto path = [&](const char* kind) { return directory + "/" + name + "_" + kind + ".png"; };
  std::vector<std::string> written{path("parts"), path("rise"), path("mesh")};
  draw_parts_picture(picture, written[0]);
  draw_rise_picture(picture, written[1]);
  draw_mesh_picture(picture, written[2]);
  if (picture.displacements_m.size() > 0) {
    written.push_back(path("deformed"));
    draw_deformed_picture(picture, written.back());
    written.push_back(path("stress"));
    draw_stress_picture(picture, written.back());
  }
  return written;
}

std::vector<std::string> write_pictures(const std::string& directory, const std::string& name, const FeModel& model,
                                        const Eigen::VectorXd& temperatures_K, const PictureState& state) {
  const AffineModel& affine = model.affine();
  const Lattice lattice = lattice_of(model);
  const auto nodes = static_cast<Eigen::Index>(lattice.nodes.size());
  SectionPicture picture{model.description(), model.section(), lattice, state, {}, {}, {}, {}, {}, {}, {},
                         model.quality()};
  picture.rises_K = temperatures_K.head(nodes).array() - state.datum_K;
  const Eigen::MatrixXd stresses_Pa = model.stresses_Pa(temperatures_K);
  if (stresses_Pa.rows() > 0) {
    picture.displacements_m = model.displacements_m(temperatures_K);
    picture.von_mises_Pa.resize(nodes);
    for (Eigen::Index i = 0; i < nodes; ++i) picture.von_mises_Pa[i] = von_mises_Pa(stress_from(stresses_Pa.row(i)));
  }
  for (const FeKeyPoint& point : affine.key_points) {
    picture.key_point_rises_K.push_back({point.name, point.row.dot(temperatures_K) - state.datum_K});
  }
  const Eigen::VectorXd warmed_K = temperatures_K.array() - affine.boundaries.reference_temperature_K;
  for (const FeDeformation& output : affine.deformations) {
    picture.deformation_um.push_back(rom::um_per_m * output.row_m_per_K.dot(warmed_K));
  }
  for (std::size_t i = 0; i < affine.air_names.size(); ++i) {
    picture.air_rises_K.push_back(
        {affine.air_names[i], temperatures_K[nodes + static_cast<Eigen::Index>(i)] - state.datum_K});
  }
  for (const rom::HeatSource& source : affine.boundaries.sources) {
    picture.heats_W.push_back({source.name, source.nominal_W});
  }
  return write_pictures(directory, name, picture);
}

}  // namespace spindle_twin::fem_offline

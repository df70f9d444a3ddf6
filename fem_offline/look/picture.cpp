#include "fem_offline/look/picture.hpp"

#include "fem_offline/look/picture_frame.hpp"

namespace spindle_twin::fem_offline {

std::vector<std::string> write_pictures(const std::string& directory, const std::string& name,
                                        const SectionPicture& picture) {
  const auto path = [&](const char* kind) { return directory + "/" + name + "_" + kind + ".png"; };
  std::vector<std::string> written{path("parts"), path("rise")};
  draw_parts_picture(picture)->save(written[0]);
  draw_rise_picture(picture)->save(written[1]);
  return written;
}

SectionPicture picture_of(const FeModel& model, const Eigen::VectorXd& temperatures_K, const PictureState& state) {
  const AffineModel& affine = model.affine();
  SectionPicture picture{model.description(), model.section(), lattice_of(model), state, {}, {}, {}, {}};
  const auto nodes = static_cast<Eigen::Index>(picture.lattice.nodes.size());
  picture.rises_K = temperatures_K.head(nodes).array() - state.datum_K;
  for (const FeKeyPoint& point : affine.key_points) {
    picture.key_point_rises_K.push_back({point.name, point.row.dot(temperatures_K) - state.datum_K});
  }
  for (std::size_t i = 0; i < affine.air_names.size(); ++i) {
    picture.air_rises_K.push_back(
        {affine.air_names[i], temperatures_K[nodes + static_cast<Eigen::Index>(i)] - state.datum_K});
  }
  for (const rom::HeatSource& source : affine.boundaries.sources) {
    picture.heats_W.push_back({source.name, source.nominal_W});
  }
  return picture;
}

}  // namespace spindle_twin::fem_offline

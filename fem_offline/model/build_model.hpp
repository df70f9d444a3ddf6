#pragma once

#include <memory>
#include <string>

#include "fem_offline/mesh/section.hpp"
#include "fem_offline/model/affine_model.hpp"

namespace spindle_twin::fem_offline {

/// The FE model behind an AffineModel: keeps mesh and dof numbering so that fields can be written.
class FeModel {
 public:
  FeModel(const Spindle& spindle, const Section& section);
  ~FeModel();
  FeModel(FeModel&&) noexcept;
  FeModel& operator=(FeModel&&) noexcept;

  const AffineModel& affine() const;

  /// Writes DIR/<name>.vtu with temperature (degC), rise (K), part and displacement (m).
  void write_vtu(const std::string& directory, const std::string& name, const Eigen::VectorXd& temperatures_K) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// read_spindle, build_section and FeModel in one call.
FeModel build_fe_model(const std::string& spindle_path);

}  // namespace spindle_twin::fem_offline

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "fem_offline/mesh/mesh_quality.hpp"
#include "fem_offline/mesh/section.hpp"
#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/model/exact_field.hpp"
#include "fem_offline/model/stress.hpp"

namespace spindle_twin::fem_offline {

struct ProbedStress {
  std::string name;
  Stress stress;
};

template <int dim>
struct Discretisation;

/// The FE model behind an AffineModel: keeps mesh and dof numbering so that fields can be written.
class FeModel {
 public:
  FeModel(const Spindle& spindle, const Section& section);
  ~FeModel();
  FeModel(FeModel&&) noexcept;
  FeModel& operator=(FeModel&&) noexcept;

  const AffineModel& affine() const&;
  /// The same, of a model of which nothing else is wanted: mesh and elastic factor, most of its memory, go.
  AffineModel affine() &&;
  /// Frees the elastic factor, for a caller that wants no more displacements and stresses: they throw std::logic_error.
  void forget_growth();
  /// Shapes of the elements, per part.
  const std::vector<PartQuality>& quality() const;
  const Spindle& description() const;
  const Section& section() const;
  /// Mesh, elements and unknowns (model/discretisation.hpp).
  const Discretisation<2>& discretisation() const;
  std::size_t element_count() const;

  /// L2 errors of a field given at the unknowns (air volumes ignored) against a closed form.
  FieldError error_against(const ExactField& exact, const Eigen::VectorXd& nodal) const;

  /// Displacements of a field of temperatures, component c (r, z) of place i at 2i + c; all 0 if the description asks
  /// for no mechanics. [m]
  Eigen::VectorXd displacements_m(const Eigen::VectorXd& temperatures_K) const;
  /// Stress at every FE place, n x 4 (σ_rr, σ_zz, σ_tt, σ_rz), averaged within each part; no rows if the description
  /// asks for no mechanics. [Pa]
  Eigen::MatrixXd stresses_Pa(const Eigen::VectorXd& temperatures_K) const;
  /// The same at one point of a part. Throws std::logic_error if no element is there or no mechanics were asked for.
  Stress stress_at(std::size_t part, const Point& at, const Eigen::VectorXd& temperatures_K) const;
  /// At the description's stress probes.
  std::vector<ProbedStress> probed_stresses(const Eigen::VectorXd& temperatures_K) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// read_spindle, build_section and FeModel in one call.
FeModel build_fe_model(const std::string& spindle_path);

}  // namespace spindle_twin::fem_offline

#include "fem_offline/reduce/loads.hpp"

#include <algorithm>

#include "rom/boundary_values/held_law.hpp"

namespace spindle_twin::fem_offline {

Eigen::MatrixXd Loads::primal(const Eigen::VectorXd& conductance_W_per_m2K) const {
  Eigen::MatrixXd columns(heat_W.rows(), heat_W.cols() + film_columns);
  columns.leftCols(heat_W.cols()) = heat_W;
  columns.rightCols(film_columns).setZero();
  for (std::size_t j = 0; j < film_m2.size(); ++j) {
    if (film_column[j] < 0) continue;
    columns.col(heat_W.cols() + film_column[j]) +=
        environment_step_K * conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * film_m2[j];
  }
  return columns;
}

Loads make_loads(const AffineModel& model, double speed_high_rpm, double load_high) {
  const rom::Boundaries& boundaries = model.boundaries;
  const Eigen::Index unknowns = model.capacity_J_per_K.rows();
  Loads loads;
  loads.heat_W = model.source_distribution;
  rom::LawDrive drive;
  rom::set_machine(boundaries.operating, drive);
  drive.speed_rpm = speed_high_rpm;
  drive.load = load_high;
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    const rom::HeatSource& source = boundaries.sources[i];
    const double fast_W =
        rom::held_heat_W(source, boundaries.reference_speed_rpm, 1.0, drive, boundaries.operating.environment_K);
    loads.heat_W.col(static_cast<Eigen::Index>(i)) *= std::max(fast_W, source.nominal_W);
  }
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    loads.film_column.push_back(boundaries.conductances[j].environment);
    loads.film_m2.emplace_back();
    if (loads.film_column[j] >= 0) {
      loads.film_m2[j] = model.conductance_terms_m2[j] * Eigen::VectorXd::Ones(unknowns);
    }
  }
  loads.film_columns = static_cast<int>(boundaries.environments.size());
  for (const rom::CoolantCircuit& circuit : boundaries.circuits) {
    for (const int segment : circuit.segments)
      loads.film_column[static_cast<std::size_t>(segment)] = loads.film_columns++;
  }
  loads.outputs.setZero(unknowns, static_cast<Eigen::Index>(model.key_points.size() + model.deformations.size() +
                                                            model.contact_pressures.size()));
  Eigen::Index column = 0;
  for (const FeKeyPoint& point : model.key_points) loads.outputs.col(column++) = point.row;
  for (const FeDeformation& deformation : model.deformations) loads.outputs.col(column++) = deformation.row_m_per_K;
  for (const FeContactPressure& pressure : model.contact_pressures) loads.outputs.col(column++) = pressure.row_Pa_per_K;
  return loads;
}

void remove_constant(Eigen::MatrixXd& columns) { columns.rowwise() -= columns.colwise().mean().eval(); }

}  // namespace spindle_twin::fem_offline

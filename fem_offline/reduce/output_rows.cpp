#include "fem_offline/reduce/output_rows.hpp"

#include "fem_offline/reduce/dense_blas.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Temperatures are the reference's, nothing has grown, and contacts have their pressures of assembly.
template <typename Pressures>
Eigen::VectorXd outputs_at_reference(const OutputLayout& layout, double reference_K, const Pressures& pressures) {
  Eigen::VectorXd outputs = Eigen::VectorXd::Zero(layout.total());
  outputs.head(layout.deformations_at()).setConstant(reference_K);
  Eigen::Index at = layout.pressures_at();
  for (const auto& pressure : pressures) outputs[at++] = pressure.assembly_pressure_Pa;
  return outputs;
}

template <typename Model>
OutputLayout layout_of(const Model& model) {
  return {static_cast<Eigen::Index>(model.key_points.size()), static_cast<Eigen::Index>(model.parts.size()),
          static_cast<Eigen::Index>(model.deformations.size()),
          static_cast<Eigen::Index>(model.contact_pressures.size())};
}

/// Calls take(row) for each output but the maxima, in the order of OutputLayout.
template <typename Model, typename Take>
void for_each_linear_row(const Model& model, const Take& take) {
  for (const auto& point : model.key_points) take(point.row);
  for (const auto& part : model.parts) take(part.mean_row);
  for (const auto& deformation : model.deformations) take(deformation.row_m_per_K);
  for (const auto& pressure : model.contact_pressures) take(pressure.row_Pa_per_K);
}

}  // namespace

OutputLayout output_layout(const AffineModel& model) { return layout_of(model); }

OutputRows output_rows_of(const rom::Network& network) {
  OutputRows rows;
  rows.layout = layout_of(network);
  rows.at_reference =
      outputs_at_reference(rows.layout, network.boundaries.reference_temperature_K, network.contact_pressures);
  rows.linear.resize(rows.layout.total() - rows.layout.parts, network.capacity_J_per_K.rows());
  Eigen::Index at = 0;
  for_each_linear_row(network, [&](const auto& row) { rows.linear.row(at++) = row.transpose(); });
  for (const rom::PartOutput& part : network.parts) rows.extremes.push_back(part.candidate_rows);
  return rows;
}

OutputRows project_output_rows(const AffineModel& model, const Eigen::MatrixXd& basis, const PartExtremes& extremes) {
  OutputRows rows;
  rows.layout = layout_of(model);
  rows.at_reference =
      outputs_at_reference(rows.layout, model.boundaries.reference_temperature_K, model.contact_pressures);
  rows.linear.resize(rows.layout.total() - rows.layout.parts, basis.cols());
  Eigen::Index at = 0;
  for_each_linear_row(model, [&](const auto& row) { rows.linear.row(at++) = row.transpose() * basis; });
  for (std::size_t part = 0; part < model.parts.size(); ++part) {
    rows.extremes.push_back(extreme_rows(model.parts[part], extremes[part], basis));
  }
  return rows;
}

Eigen::MatrixXd extreme_rows(const FePart& part, const std::vector<int>& points, const Eigen::MatrixXd& basis) {
  std::vector<int> unknowns;
  unknowns.reserve(points.size());
  for (const int point : points) unknowns.push_back(part.dofs[static_cast<std::size_t>(point)]);
  return basis(unknowns, Eigen::all);
}

Eigen::MatrixXd outputs_of(const OutputRows& rows, const Eigen::MatrixXd& rises_K) {
  const OutputLayout& layout = rows.layout;
  const Eigen::MatrixXd linear = product(rows.linear, rises_K);
  Eigen::MatrixXd outputs(layout.total(), rises_K.cols());
  outputs.topRows(layout.maxima_at()) = linear.topRows(layout.maxima_at());
  for (std::size_t part = 0; part < rows.extremes.size(); ++part) {
    outputs.row(layout.maxima_at() + static_cast<Eigen::Index>(part)) =
        product(rows.extremes[part], rises_K).colwise().maxCoeff();
  }
  const Eigen::Index behind = layout.deformations + layout.pressures;
  outputs.bottomRows(behind) = linear.bottomRows(behind);
  outputs.colwise() += rows.at_reference;
  return outputs;
}

}  // namespace spindle_twin::fem_offline

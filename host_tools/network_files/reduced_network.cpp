#include "host_tools/network_files/reduced_network.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "rom/boundary_values/environments.hpp"
#include "rom/integrate/fallback_stepper.hpp"

namespace spindle_twin::host_tools {
namespace {

using Index = Eigen::Index;

constexpr double first_interval_s = 0.05;
constexpr double interval_growth = 1.5;
constexpr double longest_interval_s = 60.0;
constexpr double node_tolerances = 4.0;   // what a node may be off, which no output shows
constexpr double worthwhile_share = 0.8;  // of the nodes: with more of them nothing is gained

/// Rises over the reference temperature, one column per instant; from rest, all but the environments held between rows.
Eigen::MatrixXd rises_along(const rom::Network& network, const ScheduleCourse& course) {
  const Index nodes = network.capacity_J_per_K.rows();
  const auto stepper = rom::make_runtime_stepper(network);
  stepper->set_temperatures(
      Eigen::VectorXd::Constant(nodes, rom::rest_temperature_K(network.boundaries, course.states.front())));
  std::vector<Eigen::VectorXd> rises_K;
  for (std::size_t row = 0; row + 1 < course.time_s.size(); ++row) {
    const double length_s = course.time_s[row + 1] - course.time_s[row];
    rom::BoundaryValues values = course.values[row];
    double interval_s = first_interval_s;
    for (double time_s = 0.0; time_s < length_s;) {
      // No interval is much shorter than the one before it.
      const bool last = length_s - time_s < 1.2 * interval_s;
      const double end_s = last ? length_s : time_s + interval_s;
      const double share = 0.5 * (time_s + end_s) / length_s;
      values.environment_K =
          (1.0 - share) * course.values[row].environment_K + share * course.values[row + 1].environment_K;
      if (stepper->advance(end_s - time_s, values) != rom::StepStatus::ok) {
        throw std::runtime_error("export: the network has no solution at " +
                                 std::to_string(course.time_s[row] + end_s) + " s of the schedule");
      }
      rises_K.emplace_back(stepper->temperatures_K().array() - network.boundaries.reference_temperature_K);
      time_s = end_s;
      interval_s = std::min(longest_interval_s, interval_growth * interval_s);
    }
  }
  Eigen::MatrixXd columns(nodes, static_cast<Index>(rises_K.size()));
  for (std::size_t i = 0; i < rises_K.size(); ++i) columns.col(static_cast<Index>(i)) = rises_K[i];
  return columns;
}

/// Orthonormal: the even field, then what the rises have besides, the largest first.
Eigen::MatrixXd shapes_of(const Eigen::MatrixXd& rises_K) {
  const Index nodes = rises_K.rows();
  const Eigen::MatrixXd uneven_K = rises_K.rowwise() - rises_K.colwise().mean();
  Eigen::MatrixXd squares = uneven_K * uneven_K.transpose();
  // The even field, which is not in it, gets the largest eigenvalue: all others are orthogonal to it then.
  squares.array() += 1.0 + 2.0 * squares.trace() / static_cast<double>(nodes);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(squares);
  Eigen::MatrixXd shapes = modes.eigenvectors().rowwise().reverse();
  shapes.col(0).setConstant(1.0 / std::sqrt(static_cast<double>(nodes)));
  return shapes;
}

/// Fewest shapes whose span has every rise within tolerance_K.
Index count_for(const Eigen::MatrixXd& rises_K, const Eigen::MatrixXd& shapes, double tolerance_K) {
  Eigen::MatrixXd left_K = rises_K;
  Index count = 0;
  while (count < shapes.cols() && (count == 0 || left_K.cwiseAbs().maxCoeff() > tolerance_K)) {
    const Eigen::RowVectorXd amounts_K = shapes.col(count).transpose() * rises_K;
    left_K.noalias() -= shapes.col(count) * amounts_K;
    ++count;
  }
  return count;
}

/// F or, where it has more columns than rows, a square factor with the same F Fᵀ.
Eigen::MatrixXd fewest_columns(const Eigen::MatrixXd& factor) {
  if (factor.cols() <= factor.rows()) return factor;
  const Eigen::HouseholderQR<Eigen::MatrixXd> parts(factor.transpose());
  const Eigen::MatrixXd upper = parts.matrixQR().topRows(factor.rows()).triangularView<Eigen::Upper>();
  return upper.transpose();
}

struct Projection {
  rom::Network network;
  Eigen::MatrixXd interpolation;  // Ψ
};

Projection project(const rom::Network& full, const Eigen::MatrixXd& shapes) {
  const Index count = shapes.cols();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> pivots(shapes.transpose());
  std::vector<Index> chosen;
  for (Index i = 0; i < count; ++i) chosen.push_back(pivots.colsPermutation().indices()[i]);
  std::sort(chosen.begin(), chosen.end());
  const Eigen::MatrixXd at_chosen = shapes(chosen, Eigen::all);
  Projection made{full, at_chosen.transpose().partialPivLu().solve(shapes.transpose()).transpose()};
  const Eigen::MatrixXd& interpolation = made.interpolation;
  const Eigen::MatrixXd transposed = interpolation.transpose();

  rom::Network& network = made.network;
  const auto symmetric = [](const Eigen::MatrixXd& matrix) {
    return Eigen::MatrixXd(0.5 * (matrix + matrix.transpose()));
  };
  network.capacity_J_per_K = symmetric(transposed * full.capacity_J_per_K * interpolation);
  network.conduction_W_per_K = symmetric(transposed * full.conduction_W_per_K * interpolation);
  network.source_distribution = transposed * full.source_distribution;
  for (Eigen::MatrixXd& factor : network.factors_m) factor = fewest_columns(transposed * factor);
  const auto reduce = [&](Eigen::VectorXd& row) { row = transposed * row; };
  for (rom::KeyPoint& point : network.key_points) reduce(point.row);
  for (rom::PartOutput& part : network.parts) {
    reduce(part.mean_row);
    part.candidate_rows = part.candidate_rows * interpolation;
  }
  for (rom::DeformationOutput& output : network.deformations) reduce(output.row_m_per_K);
  for (rom::ContactPressureOutput& output : network.contact_pressures) reduce(output.row_Pa_per_K);
  network.nodes.clear();
  for (const Index node : chosen) network.nodes.push_back(full.nodes[static_cast<std::size_t>(node)]);
  return made;
}

/// Rows of the key points and of the parts' means.
Eigen::MatrixXd temperature_rows(const rom::Network& network) {
  Eigen::MatrixXd rows(static_cast<Index>(network.key_points.size() + network.parts.size()),
                       network.capacity_J_per_K.rows());
  Index row = 0;
  for (const rom::KeyPoint& point : network.key_points) rows.row(row++) = point.row;
  for (const rom::PartOutput& part : network.parts) rows.row(row++) = part.mean_row;
  return rows;
}

}  // namespace

ReducedNetwork reduced_network(const rom::Network& network, const ScheduleCourse& course, double tolerance_K) {
  const Eigen::MatrixXd rises_K = rises_along(network, course);
  const Eigen::MatrixXd shapes = shapes_of(rises_K);
  const auto most = static_cast<Index>(worthwhile_share * static_cast<double>(network.capacity_J_per_K.rows()));
  Index count = count_for(rises_K, shapes, tolerance_K);
  const Eigen::MatrixXd rows = temperature_rows(network);
  for (; count <= most; count += 1 + count / 16) {
    Projection reduced = project(network, shapes.leftCols(count));
    const Eigen::MatrixXd error_K = reduced.interpolation * rises_along(reduced.network, course) - rises_K;
    const double node_K = error_K.cwiseAbs().maxCoeff();
    const double output_K = rows.rows() > 0 ? (rows * error_K).cwiseAbs().maxCoeff() : node_K;
    if (output_K <= tolerance_K && node_K <= node_tolerances * tolerance_K) {
      return {std::move(reduced.network), output_K, node_K};
    }
  }
  return {network};
}

}  // namespace spindle_twin::host_tools

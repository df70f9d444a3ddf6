#include <algorithm>

#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr Eigen::Index columns_at_once = 64;  ///< of what a matrix makes of the basis

}  // namespace

RichModel project_model(const AffineModel& model, const Loads& loads, const Eigen::MatrixXd& basis, int threads) {
  RichModel rich;
  rich.dense.conductance_terms.resize(model.conductance_terms_m2.size());
  const int terms = static_cast<int>(model.conductance_terms_m2.size());
  for_each_index(terms + 2, threads, [&](int index, int) {
    const SparseMatrix& full = index == 0   ? model.capacity_J_per_K
                               : index == 1 ? model.conduction_W_per_K
                                            : model.conductance_terms_m2[static_cast<std::size_t>(index - 2)];
    // Film and contact terms touch few unknowns: gather those rows before the dense product.
    std::vector<int> touched;
    std::vector<int> place(static_cast<std::size_t>(full.rows()), -1);
    for (int column = 0; column < full.outerSize(); ++column) {
      if (!SparseMatrix::InnerIterator(full, column)) continue;
      place[static_cast<std::size_t>(column)] = static_cast<int>(touched.size());
      touched.push_back(column);
    }
    // A matrix that touches all is projected without a copy of the basis.
    const bool touches_all = static_cast<Eigen::Index>(touched.size()) == basis.rows();
    const Eigen::MatrixXd gathered = touches_all ? Eigen::MatrixXd() : Eigen::MatrixXd(basis(touched, Eigen::all));
    const Eigen::MatrixXd& rows = touches_all ? basis : gathered;
    std::vector<Eigen::Triplet<double>> entries;
    for (int column = 0; column < full.outerSize(); ++column) {
      for (SparseMatrix::InnerIterator item(full, column); item; ++item) {
        entries.emplace_back(place[static_cast<std::size_t>(item.row())], place[static_cast<std::size_t>(column)],
                             item.value());
      }
    }
    SparseMatrix compact(rows.rows(), rows.rows());
    compact.setFromTriplets(entries.begin(), entries.end());
    Eigen::MatrixXd small(rows.cols(), rows.cols());
    for (Eigen::Index first = 0; first < rows.cols(); first += columns_at_once) {
      const Eigen::Index count = std::min(columns_at_once, rows.cols() - first);
      small.middleCols(first, count) = transposed_product(rows, compact * rows.middleCols(first, count));
    }
    small = (0.5 * (small + small.transpose())).eval();
    if (index >= 2) {
      rich.dense.conductance_terms[static_cast<std::size_t>(index - 2)] = PackedSymmetric(small);
    } else {
      (index == 0 ? rich.dense.capacity : rich.dense.conduction) = small;
    }
  });
  rich.dense.walls_m2 = Eigen::MatrixXd::Zero(basis.cols(), terms);
  for (std::size_t j = 0; j < loads.film_m2.size(); ++j) {
    if (loads.film_m2[j].size() > 0) {
      rich.dense.walls_m2.col(static_cast<Eigen::Index>(j)) = basis.transpose() * loads.film_m2[j];
    }
  }
  rich.dense.source_distribution = basis.transpose() * model.source_distribution;
  rich.dense.uniform = basis.transpose() * Eigen::VectorXd::Ones(basis.rows());
  rich.outputs = basis.transpose() * loads.outputs;
  const Eigen::VectorXi points = pivot_rows(basis);
  rich.points = basis(points, Eigen::all);
  for (const int point : points) {
    const int part = model.places[static_cast<std::size_t>(point)].part;
    rich.part_of_point.push_back(part < 0 ? static_cast<int>(model.parts.size()) : part);
  }
  return rich;
}

}  // namespace spindle_twin::fem_offline

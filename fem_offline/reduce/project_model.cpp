#include <algorithm>

#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr Eigen::Index columns_at_once = 64;  ///< of what a matrix makes of the basis
/// Below this share of the largest eigenvalue a projected term holds rounding only.
constexpr double rank_tolerance = 1e-14;

/// Eigenvalues of a symmetric matrix without negative ones, and their eigenvectors.
SymmetricModes modes_above_rounding(const Eigen::MatrixXd& matrix) {
  SymmetricModes modes = symmetric_modes(matrix);
  const Eigen::Index size = modes.values.size();
  Eigen::Index rank = 0;
  while (rank < size && modes.values[size - 1 - rank] > rank_tolerance * modes.values[size - 1]) ++rank;
  return {modes.values.tail(rank), modes.vectors.rightCols(rank)};
}

/// F with FFᵀ = term, smallest rank that rounding allows.
Eigen::MatrixXd symmetric_factor(const Eigen::MatrixXd& term) {
  const SymmetricModes modes = modes_above_rounding(term);
  return modes.vectors * modes.values.cwiseSqrt().asDiagonal();
}

/// Sparse matrix without the rows and columns that it does not touch.
struct CompactTerm {
  std::vector<int> touched;
  SparseMatrix matrix;
};

CompactTerm compact(const SparseMatrix& term) {
  CompactTerm result;
  std::vector<int> place(static_cast<std::size_t>(term.rows()), -1);
  for (int column = 0; column < term.outerSize(); ++column) {
    if (!SparseMatrix::InnerIterator(term, column)) continue;
    place[static_cast<std::size_t>(column)] = static_cast<int>(result.touched.size());
    result.touched.push_back(column);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (int column = 0; column < term.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator item(term, column); item; ++item) {
      entries.emplace_back(place[static_cast<std::size_t>(item.row())], place[static_cast<std::size_t>(column)],
                           item.value());
    }
  }
  const auto size = static_cast<Eigen::Index>(result.touched.size());
  result.matrix.resize(size, size);
  result.matrix.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace

Eigen::MatrixXd project_term(const SparseMatrix& term, const Eigen::MatrixXd& basis) {
  // Film and contact terms touch few unknowns: gather those rows before the dense product.
  const CompactTerm own = compact(term);
  // A matrix that touches all is projected without a copy of the basis.
  const bool touches_all = own.matrix.rows() == basis.rows();
  const Eigen::MatrixXd gathered = touches_all ? Eigen::MatrixXd() : Eigen::MatrixXd(basis(own.touched, Eigen::all));
  const Eigen::MatrixXd& rows = touches_all ? basis : gathered;
  Eigen::MatrixXd small(rows.cols(), rows.cols());
  for (Eigen::Index first = 0; first < rows.cols(); first += columns_at_once) {
    const Eigen::Index count = std::min(columns_at_once, rows.cols() - first);
    small.middleCols(first, count) = transposed_product(rows, own.matrix * rows.middleCols(first, count));
  }
  return 0.5 * (small + small.transpose());
}

Eigen::MatrixXd project_term_factor(const SparseMatrix& term, const Eigen::MatrixXd& basis) {
  const CompactTerm own = compact(term);
  if (own.matrix.rows() >= basis.cols()) return symmetric_factor(project_term(term, basis));
  // K = GGᵀ and F = VᵀG; the eigenvectors Q of FᵀF turn F into as few columns as FFᵀ has rank.
  const Eigen::MatrixXd rows = basis(own.touched, Eigen::all);
  const Eigen::MatrixXd factor = transposed_product(rows, symmetric_factor(Eigen::MatrixXd(own.matrix)));
  return product(factor, modes_above_rounding(transposed_product(factor, factor)).vectors);
}

DenseModel project_dense(const AffineModel& model, const Eigen::MatrixXd& basis, int threads) {
  DenseModel dense;
  const int terms = static_cast<int>(model.conductance_terms_m2.size());
  dense.conductance_terms = PackedTerms(basis.cols(), terms);
  dense.walls_m2 = Eigen::MatrixXd::Zero(basis.cols(), terms);
  for_each_index(terms + 2, threads, [&](int index, int) {
    if (index == 0) {
      dense.capacity = project_term(model.capacity_J_per_K, basis);
    } else if (index == 1) {
      dense.conduction = project_term(model.conduction_W_per_K, basis);
    } else {
      const std::size_t j = static_cast<std::size_t>(index - 2);
      const SparseMatrix& term = model.conductance_terms_m2[j];
      dense.conductance_terms.set(index - 2, project_term(term, basis));
      if (model.boundaries.conductances[j].environment < 0) return;
      dense.walls_m2.col(index - 2) = basis.transpose() * (term * Eigen::VectorXd::Ones(basis.rows()));
    }
  });
  dense.source_distribution = basis.transpose() * model.source_distribution;
  dense.uniform = basis.transpose() * Eigen::VectorXd::Ones(basis.rows());
  return dense;
}

RichModel project_model(const AffineModel& model, const Loads& loads, const Eigen::MatrixXd& basis, int threads) {
  RichModel rich;
  rich.dense = project_dense(model, basis, threads);
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

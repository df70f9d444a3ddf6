#include "fem_offline/reduce/shifted_factor.hpp"

#include <cholmod.h>

#include <algorithm>
#include <stdexcept>

namespace spindle_twin::fem_offline {

AffinePattern::AffinePattern(const AffineModel& model) {
  SparseMatrix sum = model.capacity_J_per_K.cwiseAbs() + model.conduction_W_per_K.cwiseAbs();
  for (const SparseMatrix& term : model.conductance_terms_m2) sum += SparseMatrix(term.cwiseAbs());
  lower_ = sum.triangularView<Eigen::Lower>();
  lower_.makeCompressed();
  capacity_ = positions(model.capacity_J_per_K);
  conduction_ = positions(model.conduction_W_per_K);
  for (const SparseMatrix& term : model.conductance_terms_m2) conductance_terms_.push_back(positions(term));
}

std::vector<AffinePattern::Entry> AffinePattern::positions(const SparseMatrix& term) const {
  std::vector<Entry> entries;
  const int* starts = lower_.outerIndexPtr();
  const int* rows = lower_.innerIndexPtr();
  for (int column = 0; column < term.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator item(term, column); item; ++item) {
      if (item.row() < column) continue;
      const int* found =
          std::lower_bound(rows + starts[column], rows + starts[column + 1], static_cast<int>(item.row()));
      entries.push_back({static_cast<int>(found - rows), item.value()});
    }
  }
  return entries;
}

void AffinePattern::assemble(const Eigen::VectorXd& conductance_W_per_m2K, double shift_per_s,
                             Eigen::VectorXd& values) const {
  values.setZero(lower_.nonZeros());
  for (const Entry& entry : conduction_) values[entry.position] += entry.value;
  for (const Entry& entry : capacity_) values[entry.position] += shift_per_s * entry.value;
  for (std::size_t j = 0; j < conductance_terms_.size(); ++j) {
    const double g = conductance_W_per_m2K[static_cast<Eigen::Index>(j)];
    for (const Entry& entry : conductance_terms_[j]) values[entry.position] += g * entry.value;
  }
}

struct ShiftedFactor::Impl {
  const AffinePattern& pattern;
  cholmod_common common{};
  cholmod_sparse matrix{};
  cholmod_factor* factor = nullptr;
  Eigen::VectorXd values;

  explicit Impl(const AffinePattern& shared) : pattern(shared) {
    cholmod_start(&common);
    common.print = 0;
    const SparseMatrix& lower = pattern.lower();
    values.setZero(lower.nonZeros());
    matrix.nrow = matrix.ncol = static_cast<std::size_t>(lower.rows());
    matrix.nzmax = static_cast<std::size_t>(lower.nonZeros());
    matrix.p = const_cast<int*>(lower.outerIndexPtr());
    matrix.i = const_cast<int*>(lower.innerIndexPtr());
    matrix.x = values.data();
    matrix.stype = -1;
    matrix.itype = CHOLMOD_INT;
    matrix.xtype = CHOLMOD_REAL;
    matrix.dtype = CHOLMOD_DOUBLE;
    matrix.sorted = 1;
    matrix.packed = 1;
    factor = cholmod_analyze(&matrix, &common);
  }
  ~Impl() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
};

ShiftedFactor::ShiftedFactor(const AffinePattern& pattern) : impl_(std::make_unique<Impl>(pattern)) {
  if (impl_->factor == nullptr) throw std::runtime_error("CHOLMOD could not analyse the conduction matrix");
}

ShiftedFactor::~ShiftedFactor() = default;

void ShiftedFactor::factorise(const Eigen::VectorXd& conductance_W_per_m2K, double shift_per_s) {
  impl_->pattern.assemble(conductance_W_per_m2K, shift_per_s, impl_->values);
  impl_->matrix.x = impl_->values.data();
  cholmod_factorize(&impl_->matrix, impl_->factor, &impl_->common);
  if (impl_->common.status != CHOLMOD_OK) throw std::runtime_error("the conduction matrix is not positive definite");
}

Eigen::MatrixXd ShiftedFactor::solve(const Eigen::MatrixXd& right_hand_sides) {
  cholmod_dense b{};
  b.nrow = b.d = static_cast<std::size_t>(right_hand_sides.rows());
  b.ncol = static_cast<std::size_t>(right_hand_sides.cols());
  b.nzmax = b.nrow * b.ncol;
  b.x = const_cast<double*>(right_hand_sides.data());
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* x = cholmod_solve(CHOLMOD_A, impl_->factor, &b, &impl_->common);
  if (x == nullptr) throw std::runtime_error("CHOLMOD could not solve");
  const Eigen::MatrixXd solution = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(x->x),
                                                                     right_hand_sides.rows(), right_hand_sides.cols());
  cholmod_free_dense(&x, &impl_->common);
  return solution;
}

}  // namespace spindle_twin::fem_offline

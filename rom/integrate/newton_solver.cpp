#include "rom/integrate/newton_solver.hpp"

#include <nvector/nvector_serial.h>
#include <sundials/sundials_band.h>
#include <sunmatrix/sunmatrix_band.h>

#include <Eigen/Eigenvalues>
#include <stdexcept>

namespace spindle_twin::rom {
namespace {

SUNLinearSolver_Type get_type(SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; }

int initialize(SUNLinearSolver) { return SUNLS_SUCCESS; }

int setup(SUNLinearSolver, SUNMatrix) { return SUNLS_SUCCESS; }

int solve_view(SUNLinearSolver view, SUNMatrix, N_Vector solution, N_Vector right_side, realtype) {
  static_cast<NewtonSolver*>(view->content)->solve(NV_DATA_S(right_side), NV_DATA_S(solution));
  return SUNLS_SUCCESS;
}

int release(SUNLinearSolver view) {
  view->content = nullptr;
  SUNLinSolFreeEmpty(view);
  return SUNLS_SUCCESS;
}

}  // namespace

void NewtonSolver::Release::operator()(_generic_SUNMatrix* matrix) const { SUNMatDestroy(matrix); }

NewtonSolver::NewtonSolver(Eigen::Index nodes, Eigen::Index segments, SUNContext context)
    : scale_(nodes),
      scratch_(nodes),
      rotation_(nodes, nodes),
      reflectors_(nodes - 1),
      workspace_(nodes),
      diagonal_(nodes),
      below_(nodes - 1),
      band_(SUNBandMatrix(nodes, 1, 1, context)),
      pivots_(nodes),
      rotated_(nodes),
      walls_(nodes, segments),
      responses_(nodes, segments),
      coupling_(segments, segments),
      met_(segments, segments),
      small_(segments, segments),
      lu_(segments),
      at_walls_(segments),
      fed_(segments),
      circuit_(segments) {
  if (!band_) throw std::runtime_error("no memory for Newton's matrix");
}

void NewtonSolver::set_matrix(const Eigen::MatrixXd& lower, const Eigen::MatrixXd& walls,
                              const Eigen::VectorXd& inverse_capacity) {
  ++decompositions_;
  // Eigen's class for this takes a vector from the heap whenever it is asked for Q, and so do the reflectors unless
  // they are multiplied out in place.
  rotation_ = lower;
  scaled_ = inverse_capacity.size() > 0;
  if (scaled_) {
    scale_ = inverse_capacity.cwiseSqrt();
    for (Eigen::Index column = 0; column < scale_.size(); ++column) {
      rotation_.col(column).array() *= scale_[column] * scale_.array();
    }
  }
  Eigen::internal::tridiagonalization_inplace(rotation_, reflectors_);
  diagonal_ = rotation_.diagonal();
  below_ = rotation_.diagonal<-1>();
  Eigen::HouseholderSequence<Eigen::MatrixXd, Eigen::VectorXd>(rotation_, reflectors_)
      .setLength(rotation_.rows() - 1)
      .setShift(1)
      .evalTo(rotation_, workspace_);
  for (Eigen::Index s = 0; s < walls.cols(); ++s) {
    scratch_ = walls.col(s);
    if (scaled_) scratch_.array() *= scale_.array();
    walls_.col(s).noalias() = rotation_.transpose() * scratch_;
  }
}

bool NewtonSolver::set_step(double gamma, const Eigen::MatrixXd& coupling) {
  SUNMatZero(band_.get());
  const Eigen::Index n = diagonal_.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    realtype* column = SUNBandMatrix_Column(band_.get(), i);
    SM_COLUMN_ELEMENT_B(column, i, i) = 1.0 + gamma * diagonal_[i];
    if (i > 0) SM_COLUMN_ELEMENT_B(column, i - 1, i) = gamma * below_[i - 1];
    if (i + 1 < n) SM_COLUMN_ELEMENT_B(column, i + 1, i) = gamma * below_[i];
  }
  gamma_ = gamma;
  realtype** columns = SUNBandMatrix_Cols(band_.get());
  const sunindextype stored = SUNBandMatrix_StoredUpperBandwidth(band_.get());
  if (SUNDlsMat_bandGBTRF(columns, n, 1, 1, stored, pivots_.data()) != 0) return false;
  if (walls_.cols() == 0) return true;
  responses_ = walls_;
  for (Eigen::Index s = 0; s < walls_.cols(); ++s) {
    SUNDlsMat_bandGBTRS(columns, n, stored, 1, pivots_.data(), responses_.col(s).data());
  }
  coupling_ = gamma * coupling;
  met_ = walls_.transpose().lazyProduct(responses_);
  small_ = -coupling_.lazyProduct(met_);
  small_.diagonal().array() += 1.0;
  lu_.compute(small_);
  return lu_.matrixLU().allFinite() && (lu_.matrixLU().diagonal().array() != 0.0).all();
}

void NewtonSolver::solve(const double* b, double* x) {
  const Eigen::Index n = diagonal_.size();
  scratch_ = Eigen::Map<const Eigen::VectorXd>(b, n);
  if (scaled_) scratch_.array() /= scale_.array();
  rotated_.noalias() = rotation_.transpose() * scratch_;
  SUNDlsMat_bandGBTRS(SUNBandMatrix_Cols(band_.get()), n, SUNBandMatrix_StoredUpperBandwidth(band_.get()), 1,
                      pivots_.data(), rotated_.data());
  if (walls_.cols() > 0) {
    at_walls_.noalias() = walls_.transpose() * rotated_;
    fed_.noalias() = coupling_ * at_walls_;
    circuit_ = lu_.solve(fed_);
    rotated_.noalias() += responses_ * circuit_;
  }
  Eigen::Map<Eigen::VectorXd> solution(x, n);
  solution.noalias() = rotation_ * rotated_;
  if (scaled_) solution.array() *= scale_.array();
}

SUNLinearSolver view_for_sundials(NewtonSolver& solver, SUNContext context) {
  SUNLinearSolver view = SUNLinSolNewEmpty(context);
  if (view == nullptr) return nullptr;
  view->ops->gettype = get_type;
  view->ops->initialize = initialize;
  view->ops->setup = setup;
  view->ops->solve = solve_view;
  view->ops->free = release;
  view->content = &solver;
  return view;
}

}  // namespace spindle_twin::rom

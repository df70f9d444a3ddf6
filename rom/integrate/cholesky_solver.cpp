#include "rom/integrate/cholesky_solver.hpp"

#include <nvector/nvector_serial.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <Eigen/Cholesky>
#include <memory>

namespace spindle_twin::rom {
namespace {

using Cholesky = Eigen::LLT<Eigen::MatrixXd, Eigen::Lower>;

Cholesky& factor(SUNLinearSolver solver) { return *static_cast<Cholesky*>(solver->content); }

SUNLinearSolver_Type get_type(SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; }

int initialize(SUNLinearSolver) { return SUNLS_SUCCESS; }

int setup(SUNLinearSolver solver, SUNMatrix matrix) {
  const Eigen::Index size = SUNDenseMatrix_Rows(matrix);
  factor(solver).compute(Eigen::Map<const Eigen::MatrixXd>(SUNDenseMatrix_Data(matrix), size, size));
  // A positive value tells CVODE to retry with a smaller step before it gives up.
  return factor(solver).info() == Eigen::Success ? SUNLS_SUCCESS : SUNLS_LUFACT_FAIL;
}

int solve(SUNLinearSolver solver, SUNMatrix, N_Vector solution, N_Vector right_side, realtype) {
  const Eigen::Index size = NV_LENGTH_S(solution);
  Eigen::Map<Eigen::VectorXd> x(NV_DATA_S(solution), size);
  x = Eigen::Map<const Eigen::VectorXd>(NV_DATA_S(right_side), size);
  factor(solver).matrixL().solveInPlace(x);
  factor(solver).matrixU().solveInPlace(x);
  return SUNLS_SUCCESS;
}

int release(SUNLinearSolver solver) {
  delete static_cast<Cholesky*>(solver->content);
  solver->content = nullptr;
  SUNLinSolFreeEmpty(solver);
  return SUNLS_SUCCESS;
}

}  // namespace

SUNLinearSolver make_cholesky_solver(sunindextype size, SUNContext context) {
  auto content = std::make_unique<Cholesky>(size);
  SUNLinearSolver solver = SUNLinSolNewEmpty(context);
  if (solver == nullptr) return nullptr;
  solver->ops->gettype = get_type;
  solver->ops->initialize = initialize;
  solver->ops->setup = setup;
  solver->ops->solve = solve;
  solver->ops->free = release;
  solver->content = content.release();
  return solver;
}

}  // namespace spindle_twin::rom

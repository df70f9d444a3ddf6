#pragma once

#include <sundials/sundials_linearsolver.h>

namespace spindle_twin::rom {

/// A SUNDIALS direct solver for symmetric positive definite matrices of order `size`: Eigen's Cholesky of the lower
/// triangle of a dense SUNMatrix (the strict upper triangle is not read). Half the work of SUNLinSol_Dense's LU, which
/// would not see the symmetry. Sized once; setup and solve do not allocate up to about 400 unknowns, where Eigen's
/// panel still fits its stack buffer. Free with SUNLinSolFree. Null if out of memory.
SUNLinearSolver make_cholesky_solver(sunindextype size, SUNContext context);

}  // namespace spindle_twin::rom

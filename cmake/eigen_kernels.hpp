#pragma once
// What Eigen's products, triangular solves and decompositions of double matrices come down to, compiled once, in
// eigen_kernels.cpp, instead of in every source that multiplies or solves. It is part of the precompiled headers only:
// sources do not include it, and without precompiled headers each compiles its own copy, from the same text. The names
// in Eigen::internal are those of Eigen 3.4; where another version differs, this file fails to compile, and
// -DSPINDLE_TWIN_PRECOMPILE=OFF builds without it.

#include <Eigen/Dense>

#ifndef SPINDLE_TWIN_EIGEN_KERNEL
#define SPINDLE_TWIN_EIGEN_KERNEL extern template
#endif

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wignored-attributes"  // the alignment of a packet as a template argument

namespace Eigen {
namespace internal {

using Kernel_to = blas_data_mapper<double, Index, ColMajor, 0, 1>;
using Kernel_columns = const_blas_data_mapper<double, Index, ColMajor>;
using Kernel_rows = const_blas_data_mapper<double, Index, RowMajor>;
using Kernel_traits = gebp_traits<double, double>;
using Kernel_packet = Kernel_traits::LhsPacket4Packing;
constexpr int kernel_rows = Kernel_traits::mr;
constexpr int kernel_step = Kernel_traits::LhsProgress;
constexpr int kernel_columns = Kernel_traits::nr;

// matrix * matrix
SPINDLE_TWIN_EIGEN_KERNEL struct gebp_kernel<double, double, Index, Kernel_to, kernel_rows, kernel_columns, false,
                                             false>;
SPINDLE_TWIN_EIGEN_KERNEL struct gemm_pack_rhs<double, Index, Kernel_columns, kernel_columns, ColMajor, false, false>;
SPINDLE_TWIN_EIGEN_KERNEL struct gemm_pack_rhs<double, Index, Kernel_rows, kernel_columns, RowMajor, false, false>;
SPINDLE_TWIN_EIGEN_KERNEL struct gemm_pack_rhs<double, Index, Kernel_rows, kernel_columns, RowMajor, false, true>;
SPINDLE_TWIN_EIGEN_KERNEL struct gemm_pack_rhs<double, Index, Kernel_to, kernel_columns, ColMajor, false, true>;
SPINDLE_TWIN_EIGEN_KERNEL
struct gemm_pack_lhs<double, Index, Kernel_columns, kernel_rows, kernel_step, Kernel_packet, ColMajor, false, false>;
SPINDLE_TWIN_EIGEN_KERNEL
struct gemm_pack_lhs<double, Index, Kernel_rows, kernel_rows, kernel_step, Kernel_packet, RowMajor, false, false>;
SPINDLE_TWIN_EIGEN_KERNEL
struct gemm_pack_lhs<double, Index, Kernel_to, kernel_rows, kernel_step, Kernel_packet, ColMajor, false, true>;

// matrix * vector
SPINDLE_TWIN_EIGEN_KERNEL struct general_matrix_vector_product<Index, double, Kernel_columns, ColMajor, false, double,
                                                               Kernel_rows, false, 0>;
SPINDLE_TWIN_EIGEN_KERNEL struct general_matrix_vector_product<Index, double, Kernel_columns, ColMajor, false, double,
                                                               Kernel_columns, false, 0>;
SPINDLE_TWIN_EIGEN_KERNEL struct general_matrix_vector_product<Index, double, Kernel_rows, RowMajor, false, double,
                                                               Kernel_columns, false, 0>;
SPINDLE_TWIN_EIGEN_KERNEL struct general_matrix_vector_product<Index, double, Kernel_rows, RowMajor, false, double,
                                                               Kernel_rows, false, 1>;
SPINDLE_TWIN_EIGEN_KERNEL struct selfadjoint_matrix_vector_product<double, Index, ColMajor, Lower, false, false>;

// triangles: times a matrix, a matrix times its transpose, and solved
SPINDLE_TWIN_EIGEN_KERNEL
struct product_triangular_matrix_matrix<double, Index, Lower, true, ColMajor, false, ColMajor, false, ColMajor, 1>;
SPINDLE_TWIN_EIGEN_KERNEL
struct product_triangular_matrix_matrix<double, Index, Upper, true, RowMajor, false, ColMajor, false, ColMajor, 1>;
SPINDLE_TWIN_EIGEN_KERNEL
struct product_triangular_matrix_matrix<double, Index, UnitLower, true, ColMajor, false, ColMajor, false, ColMajor, 1>;
SPINDLE_TWIN_EIGEN_KERNEL
struct product_triangular_matrix_matrix<double, Index, UnitUpper, true, RowMajor, false, ColMajor, false, ColMajor, 1>;
SPINDLE_TWIN_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor, ColMajor, 1>;
SPINDLE_TWIN_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor, ColMajor, 1>;
SPINDLE_TWIN_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor, ColMajor, 1>;
SPINDLE_TWIN_EIGEN_KERNEL
struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, ColMajor, ColMajor, 1>;
SPINDLE_TWIN_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheRight, Upper, false, RowMajor, ColMajor,
                                                         1>;

// reflectors and the tridiagonal form
SPINDLE_TWIN_EIGEN_KERNEL void tridiagonalization_inplace<MatrixXd, VectorXd>(MatrixXd&, VectorXd&);

}  // namespace internal

SPINDLE_TWIN_EIGEN_KERNEL void HouseholderSequence<MatrixXd, VectorXd, OnTheLeft>::evalTo<MatrixXd, VectorXd>(
    MatrixXd&, VectorXd&) const;

// decompositions
SPINDLE_TWIN_EIGEN_KERNEL LLT<MatrixXd>& LLT<MatrixXd>::compute<MatrixXd>(const EigenBase<MatrixXd>&);
SPINDLE_TWIN_EIGEN_KERNEL void PartialPivLU<MatrixXd>::compute();
SPINDLE_TWIN_EIGEN_KERNEL void HouseholderQR<MatrixXd>::computeInPlace();
SPINDLE_TWIN_EIGEN_KERNEL void ColPivHouseholderQR<MatrixXd>::computeInPlace();
SPINDLE_TWIN_EIGEN_KERNEL SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute<MatrixXd>(
    const EigenBase<MatrixXd>&, int);

}  // namespace Eigen

#pragma GCC diagnostic pop

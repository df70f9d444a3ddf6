#pragma once

#include <Eigen/Core>
#include <optional>

namespace spindle_twin::fem_offline {

/// A B. OpenBLAS where it is loaded and serves several threads, since it uses the vector instructions of the processor
/// at hand; else Eigen. Either way on the calling thread alone, so that the bits do not depend on the number of
/// threads.
Eigen::MatrixXd product(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b);
/// In single precision.
Eigen::MatrixXf product(const Eigen::Ref<const Eigen::MatrixXf>& a, const Eigen::Ref<const Eigen::MatrixXf>& b);
/// X Xᵀ, likewise; symmetric to the bit.
Eigen::MatrixXd product_with_transposed(const Eigen::Ref<const Eigen::MatrixXd>& x);
/// Aᵀ B, likewise.
Eigen::MatrixXd transposed_product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                   const Eigen::Ref<const Eigen::MatrixXd>& b);

/// X becomes X U⁻¹ with U the upper triangle, likewise.
void divide_by_upper(Eigen::MatrixXd& x, const Eigen::MatrixXd& upper);

/// Cholesky factor of a dense symmetric matrix, likewise.
class DenseCholesky {
 public:
  /// Reads the lower triangle. Throws std::runtime_error where the matrix is not positive definite: `what` it is.
  DenseCholesky(Eigen::MatrixXd matrix, const char* what);
  /// A⁻¹ B
  Eigen::MatrixXd solve(Eigen::MatrixXd right_hand_sides) const;

 private:
  Eigen::MatrixXd lower_;
};

/// Eigenvalues, smallest first, and orthonormal eigenvectors of a symmetric matrix.
struct SymmetricModes {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Reads the lower triangle (LAPACK's dsyevd). Throws std::runtime_error where an entry is not finite.
SymmetricModes symmetric_modes(Eigen::MatrixXd matrix);

/// A = S D S⁻¹ in real numbers: column k of S is the eigenvector of the real eigenvalue `real[k]` where `imaginary[k]`
/// is 0; columns k and k + 1 are real and imaginary part of that of `real[k] + i imaginary[k]` where it is above 0.
struct RealModes {
  Eigen::VectorXd real, imaginary;
  Eigen::MatrixXd vectors;
};

/// Of any square matrix (LAPACK's dgeev). Throws std::runtime_error where its iteration does not end.
RealModes real_modes(Eigen::MatrixXd matrix);

/// As many rows of `columns` as it has columns, chosen by Gaussian elimination with row pivoting: independent ones,
/// spread by how much combinations of the columns can vary.
Eigen::VectorXi pivot_rows(Eigen::MatrixXd columns);

}  // namespace spindle_twin::fem_offline

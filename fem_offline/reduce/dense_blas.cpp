#include "fem_offline/reduce/dense_blas.hpp"

#include <Eigen/Cholesky>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "fem_offline/sparse/cholesky.hpp"

extern "C" {
void dgemm_(const char* transpose_a, const char* transpose_b, const int* rows, const int* columns, const int* inner,
            const double* alpha, const double* a, const int* lda, const double* b, const int* ldb, const double* beta,
            double* c, const int* ldc, std::size_t, std::size_t);
void sgemm_(const char* transpose_a, const char* transpose_b, const int* rows, const int* columns, const int* inner,
            const float* alpha, const float* a, const int* lda, const float* b, const int* ldb, const float* beta,
            float* c, const int* ldc, std::size_t, std::size_t);
void dsyrk_(const char* uplo, const char* transpose, const int* n, const int* inner, const double* alpha,
            const double* a, const int* lda, const double* beta, double* c, const int* ldc, std::size_t, std::size_t);
void dtrsm_(const char* side, const char* uplo, const char* transpose, const char* unit, const int* rows,
            const int* columns, const double* alpha, const double* a, const int* lda, double* b, const int* ldb,
            std::size_t, std::size_t, std::size_t, std::size_t);
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
void dpotrs_(const char* uplo, const int* n, const int* columns, const double* a, const int* lda, double* b,
             const int* ldb, int* info, std::size_t);
void dgetrf_(const int* rows, const int* columns, double* a, const int* lda, int* pivots, int* info);
void dsyevd_(const char* job, const char* uplo, const int* n, double* a, const int* lda, double* values, double* work,
             const int* work_size, int* integers, const int* integers_size, int* info, std::size_t, std::size_t);
void dgeev_(const char* left, const char* right, const int* n, double* a, const int* lda, double* real,
            double* imaginary, double* left_vectors, const int* ld_left, double* right_vectors, const int* ld_right,
            double* work, const int* work_size, int* info, std::size_t, std::size_t);
}

namespace spindle_twin::fem_offline {
namespace {

template <typename Scalar>
using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

/// op(A) B with op(A) = A for 'N', Aᵀ for 'T'.
template <typename Scalar>
Matrix<Scalar> blas_product(char transpose, const Eigen::Ref<const Matrix<Scalar>>& a,
                            const Eigen::Ref<const Matrix<Scalar>>& b) {
  const int rows = static_cast<int>(transpose == 'N' ? a.rows() : a.cols()), columns = static_cast<int>(b.cols());
  const int inner = static_cast<int>(b.rows());
  const int lda = static_cast<int>(a.outerStride()), ldb = static_cast<int>(b.outerStride());
  Matrix<Scalar> result(rows, columns);
  if (inner == 0) result.setZero();
  if (result.size() == 0 || inner == 0) return result;
  const Scalar one = 1, zero = 0;
  if constexpr (std::is_same_v<Scalar, double>) {
    dgemm_(&transpose, "N", &rows, &columns, &inner, &one, a.data(), &lda, b.data(), &ldb, &zero, result.data(), &rows,
           1, 1);
  } else {
    sgemm_(&transpose, "N", &rows, &columns, &inner, &one, a.data(), &lda, b.data(), &ldb, &zero, result.data(), &rows,
           1, 1);
  }
  return result;
}

}  // namespace

Eigen::MatrixXd product(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b) {
  return openblas_serves_threads() ? blas_product<double>('N', a, b) : Eigen::MatrixXd(a * b);
}

Eigen::MatrixXf product(const Eigen::Ref<const Eigen::MatrixXf>& a, const Eigen::Ref<const Eigen::MatrixXf>& b) {
  return openblas_serves_threads() ? blas_product<float>('N', a, b) : Eigen::MatrixXf(a * b);
}

Eigen::MatrixXd product_with_transposed(const Eigen::Ref<const Eigen::MatrixXd>& x) {
  const int rows = static_cast<int>(x.rows()), inner = static_cast<int>(x.cols());
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(rows, rows);
  if (openblas_serves_threads() && x.size() > 0) {
    const int stride = static_cast<int>(x.outerStride());
    const double one = 1.0, zero = 0.0;
    dsyrk_("L", "N", &rows, &inner, &one, x.data(), &stride, &zero, lower.data(), &rows, 1, 1);
  } else {
    lower.selfadjointView<Eigen::Lower>().rankUpdate(x);
  }
  return lower.selfadjointView<Eigen::Lower>();
}

Eigen::MatrixXd transposed_product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                   const Eigen::Ref<const Eigen::MatrixXd>& b) {
  return openblas_serves_threads() ? blas_product<double>('T', a, b) : Eigen::MatrixXd(a.transpose() * b);
}

void divide_by_upper(Eigen::MatrixXd& x, const Eigen::MatrixXd& upper) {
  if (!openblas_serves_threads()) {
    upper.triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(x);
    return;
  }
  const int rows = static_cast<int>(x.rows()), columns = static_cast<int>(x.cols());
  const double one = 1.0;
  if (x.size() > 0) {
    dtrsm_("R", "U", "N", "N", &rows, &columns, &one, upper.data(), &columns, x.data(), &rows, 1, 1, 1, 1);
  }
}

DenseCholesky::DenseCholesky(Eigen::MatrixXd matrix, const char* what) : lower_(std::move(matrix)) {
  bool definite = true;
  if (openblas_serves_threads()) {
    const int size = static_cast<int>(lower_.rows());
    int info = 0;
    dpotrf_("L", &size, lower_.data(), &size, &info, 1);
    definite = info == 0;
  } else {
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(lower_);
    definite = factor.info() == Eigen::Success;
  }
  if (!definite) throw std::runtime_error(std::string(what) + " is not positive definite");
}

Eigen::MatrixXd DenseCholesky::solve(Eigen::MatrixXd right_hand_sides) const {
  if (openblas_serves_threads()) {
    const int size = static_cast<int>(lower_.rows()), columns = static_cast<int>(right_hand_sides.cols());
    int info = 0;
    dpotrs_("L", &size, &columns, lower_.data(), &size, right_hand_sides.data(), &size, &info, 1);
    return right_hand_sides;
  }
  const auto lower = lower_.triangularView<Eigen::Lower>();
  lower.solveInPlace(right_hand_sides);
  lower.transpose().solveInPlace(right_hand_sides);
  return right_hand_sides;
}

namespace {

/// LAPACK's decompositions call the BLAS: one thread at a time where that serves no more.
std::unique_lock<std::mutex> turn_at_lapack() {
  static std::mutex one_at_a_time;
  return openblas_serves_threads() ? std::unique_lock<std::mutex>() : std::unique_lock(one_at_a_time);
}

}  // namespace

SymmetricModes symmetric_modes(Eigen::MatrixXd matrix) {
  const int size = static_cast<int>(matrix.rows()), ask = -1;
  SymmetricModes modes{Eigen::VectorXd(size), {}};
  if (size == 0) return modes;
  const std::unique_lock turn = turn_at_lapack();
  int info = 0;
  const auto call = [&](double* work, const int* work_size, int* integers, const int* integers_size) {
    dsyevd_("V", "L", &size, matrix.data(), &size, modes.values.data(), work, work_size, integers, integers_size, &info,
            1, 1);
  };
  double wanted = 0.0;
  int integers_size = 0;
  call(&wanted, &ask, &integers_size, &ask);
  const int work_size = static_cast<int>(wanted);
  std::vector<double> work(static_cast<std::size_t>(work_size));
  std::vector<int> integers(static_cast<std::size_t>(integers_size));
  call(work.data(), &work_size, integers.data(), &integers_size);
  if (info != 0 || !modes.values.allFinite()) throw std::runtime_error("a symmetric matrix has no eigenvectors");
  modes.vectors = std::move(matrix);
  return modes;
}

RealModes real_modes(Eigen::MatrixXd matrix) {
  const int size = static_cast<int>(matrix.rows()), ask = -1;
  RealModes modes{Eigen::VectorXd(size), Eigen::VectorXd(size), Eigen::MatrixXd(size, size)};
  if (size == 0) return modes;
  const std::unique_lock turn = turn_at_lapack();
  double wanted = 0.0;
  int info = 0;
  const auto call = [&](double* work, const int* work_size) {
    dgeev_("N", "V", &size, matrix.data(), &size, modes.real.data(), modes.imaginary.data(), nullptr, &size,
           modes.vectors.data(), &size, work, work_size, &info, 1, 1);
  };
  call(&wanted, &ask);
  const int work_size = static_cast<int>(wanted);
  std::vector<double> work(static_cast<std::size_t>(work_size));
  call(work.data(), &work_size);
  if (info != 0 || !modes.real.allFinite()) throw std::runtime_error("a matrix has no eigenvectors");
  return modes;
}

Eigen::VectorXi pivot_rows(Eigen::MatrixXd columns) {
  const int rows = static_cast<int>(columns.rows()), count = static_cast<int>(columns.cols());
  std::vector<int> exchanged(static_cast<std::size_t>(count));
  int info = 0;
  dgetrf_(&rows, &count, columns.data(), &rows, exchanged.data(), &info);
  Eigen::VectorXi order = Eigen::VectorXi::LinSpaced(rows, 0, rows - 1);
  for (int i = 0; i < count; ++i) std::swap(order[i], order[exchanged[static_cast<std::size_t>(i)] - 1]);
  return order.head(count);
}

}  // namespace spindle_twin::fem_offline

#include "fem_offline/solve/cholesky.hpp"

#include <cholmod.h>
#include <dlfcn.h>
#include <omp.h>

#include <stdexcept>

namespace spindle_twin::fem_offline {
namespace {

// Below it a supernodal factor costs more than a simplicial one.
constexpr Eigen::Index least_supernodal_unknowns = 50000;

/// Whether two threads may call the BLAS at once; if it is OpenBLAS, its own threads are switched off. OpenBLAS built
/// without threads (Debian's libopenblas0-serial) is the one that may not: supernodal factors of a good matrix then
/// fail at random.
bool blas_serves_two_threads() {
  static const bool serves = [] {
    const auto parallel = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
    const auto set_threads = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
    if (set_threads) set_threads(1);
    return !parallel || parallel() != 0;
  }();
  return serves;
}

/// CHOLMOD's settings and workspace; kept alive by every factor that was made with it.
struct Common {
  cholmod_common settings;
  explicit Common(Eigen::Index unknowns) {
    cholmod_start(&settings);
    const bool supernodal = blas_serves_two_threads() && unknowns >= least_supernodal_unknowns;
    settings.supernodal = supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
    settings.final_ll = 1;
    settings.print = 0;
    settings.error_handler = nullptr;
    settings.try_catch = 1;
  }
  ~Common() { cholmod_finish(&settings); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
};

/// CHOLMOD's view of an Eigen matrix; it only reads.
cholmod_sparse view(const SparseMatrix& lower) {
  cholmod_sparse sparse{};
  sparse.nrow = static_cast<std::size_t>(lower.rows());
  sparse.ncol = static_cast<std::size_t>(lower.cols());
  sparse.nzmax = static_cast<std::size_t>(lower.nonZeros());
  sparse.p = const_cast<int*>(lower.outerIndexPtr());
  sparse.i = const_cast<int*>(lower.innerIndexPtr());
  sparse.x = const_cast<double*>(lower.valuePtr());
  sparse.stype = -1;
  sparse.itype = CHOLMOD_INT;
  sparse.xtype = CHOLMOD_REAL;
  sparse.dtype = CHOLMOD_DOUBLE;
  sparse.sorted = 1;
  sparse.packed = 1;
  return sparse;
}

}  // namespace

struct CholeskyFactor::Impl {
  explicit Impl(Eigen::Index unknowns) : common(unknowns) {}

  Common common;
  cholmod_factor* factor = nullptr;
  cholmod_dense* solution = nullptr;
  cholmod_dense* workspace_y = nullptr;
  cholmod_dense* workspace_e = nullptr;

  ~Impl() {
    cholmod_free_dense(&solution, &common.settings);
    cholmod_free_dense(&workspace_y, &common.settings);
    cholmod_free_dense(&workspace_e, &common.settings);
    cholmod_free_factor(&factor, &common.settings);
  }
  void factorise(const SparseMatrix& lower) {
    // CHOLMOD asks for four threads per factor, which wait in loops and on a busy computer cost far more than the
    // work; cases run in parallel instead. The setting holds for the calling thread.
    omp_set_max_active_levels(0);
    cholmod_sparse matrix = view(lower);
    if (!factor || !cholmod_factorize(&matrix, factor, &common.settings) || factor->minor < factor->n) {
      throw std::runtime_error("the thermal matrix is not positive definite: no film leads to an environment");
    }
  }
};

CholeskyFactor::CholeskyFactor(const SparseMatrix& lower) : impl_(std::make_unique<Impl>(lower.rows())) {
  cholmod_sparse matrix = view(lower);
  impl_->factor = cholmod_analyze(&matrix, &impl_->common.settings);
  impl_->factorise(lower);
}

CholeskyFactor::CholeskyFactor(const CholeskyFactor& pattern, const SparseMatrix& lower)
    : impl_(std::make_unique<Impl>(lower.rows())) {
  impl_->factor = cholmod_copy_factor(pattern.impl_->factor, &impl_->common.settings);
  impl_->factorise(lower);
}

CholeskyFactor::~CholeskyFactor() = default;
CholeskyFactor::CholeskyFactor(CholeskyFactor&&) noexcept = default;
CholeskyFactor& CholeskyFactor::operator=(CholeskyFactor&&) noexcept = default;

void CholeskyFactor::solve(const Eigen::VectorXd& right_hand_side, Eigen::VectorXd& solution) {
  cholmod_dense given{};
  given.nrow = static_cast<std::size_t>(right_hand_side.size());
  given.ncol = 1;
  given.nzmax = given.nrow;
  given.d = given.nrow;
  given.x = const_cast<double*>(right_hand_side.data());
  given.xtype = CHOLMOD_REAL;
  given.dtype = CHOLMOD_DOUBLE;
  if (!cholmod_solve2(CHOLMOD_A, impl_->factor, &given, nullptr, &impl_->solution, nullptr, &impl_->workspace_y,
                      &impl_->workspace_e, &impl_->common.settings)) {
    throw std::runtime_error("CHOLMOD could not solve");
  }
  solution = Eigen::Map<const Eigen::VectorXd>(static_cast<const double*>(impl_->solution->x), right_hand_side.size());
}

}  // namespace spindle_twin::fem_offline

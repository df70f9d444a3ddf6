#include "fem_offline/sparse/cholesky.hpp"

#include <cholmod.h>
#include <dlfcn.h>
#include <omp.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "fem_offline/sparse/cholmod_view.hpp"

namespace spindle_twin::fem_offline {
namespace {

// Operations per entry of the factor from which the BLAS pays (bench_rows: a mesh of about 30 000 thermal unknowns,
// fewer elastic ones). CHOLMOD's own 40 makes the usual mesh slower.
constexpr double least_supernodal_work = 60.0;

/// Holds OpenBLAS, if that is the BLAS, to the calling thread: its own threads wait in loops, and cases run in parallel
/// instead. Returns whether two threads may call it at once. OpenBLAS built without threads (Debian's
/// libopenblas0-serial) is the one that they may not: supernodal factors of a good matrix then fail at random.
bool hold_blas_to_one_thread() {
  const auto parallel = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
  const auto set_threads = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (set_threads) set_threads(1);
  return !parallel || parallel() != 0;
}

// At the start of the program, so that LAPACK's callers are held too.
const bool blas_serves_two_threads = hold_blas_to_one_thread();

/// CHOLMOD's settings and workspace, for one thread.
struct Common {
  cholmod_common settings;
  explicit Common(Solutions wanted) {
    cholmod_start(&settings);
    settings.supernodal = blas_serves_two_threads ? CHOLMOD_AUTO : CHOLMOD_SIMPLICIAL;
    settings.supernodal_switch = least_supernodal_work;
    // A supernodal factor is turned into columns without the zeros that its blocks brought along: a third less time per
    // solution, for a tenth more per factor.
    settings.final_asis = wanted == Solutions::few ? 1 : 0;
    settings.final_super = 0;
    settings.final_ll = 0;
    settings.final_resymbol = 1;
    settings.print = 0;
    settings.error_handler = nullptr;
    settings.try_catch = 1;
  }
  ~Common() { cholmod_finish(&settings); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
};

/// L D Lᵀ by columns, each beginning with its entry of D; a pivot that is not above zero stops a supernodal
/// factorisation, but not one by columns.
bool is_positive_definite(const cholmod_factor& factor) {
  if (factor.minor < factor.n) return false;
  if (factor.is_super != 0) return true;
  const auto* column_starts = static_cast<const int*>(factor.p);
  const auto* entries = static_cast<const double*>(factor.x);
  return std::all_of(column_starts, column_starts + factor.n, [&](int start) { return entries[start] > 0.0; });
}

}  // namespace

struct CholeskyAnalysis::Impl {
  Common common;
  cholmod_factor* factor = nullptr;

  Impl(const SparseMatrix& lower, Solutions wanted) : common(Solutions::many) {
    cholmod_sparse matrix = view_of(lower);
    // METIS begins at one seed, but its numbers come from rand(), which two orderings at once would share: then neither
    // would be that of another run.
    static std::mutex one_at_a_time;
    const std::lock_guard lock(one_at_a_time);
    if (wanted == Solutions::of_many_factors) {
      common.settings.nmethods = 1;
      common.settings.method[0].ordering = CHOLMOD_NESDIS;
    }
    factor = cholmod_analyze(&matrix, &common.settings);
    if (!factor) throw std::runtime_error("CHOLMOD could not analyse the matrix: no memory");
  }
  ~Impl() { cholmod_free_factor(&factor, &common.settings); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
};

CholeskyAnalysis::CholeskyAnalysis(const SparseMatrix& lower, Solutions wanted)
    : impl_(std::make_shared<const Impl>(lower, wanted)) {}

bool openblas_serves_threads() {
  static const bool loaded = dlsym(RTLD_DEFAULT, "openblas_get_parallel") != nullptr;
  return loaded && blas_serves_two_threads;
}

struct CholeskyFactor::Impl {
  Impl(CholeskyAnalysis shared, const SparseMatrix& lower, Solutions wanted)
      : analysis(std::move(shared)), common(wanted) {
    // CHOLMOD asks for four threads per factor, which wait in loops and on a busy computer cost far more than the
    // work; cases run in parallel instead. The setting holds for the calling thread.
    omp_set_max_active_levels(0);
    factor = cholmod_copy_factor(analysis.impl_->factor, &common.settings);
    cholmod_sparse matrix = view_of(lower);
    if (!factor || !cholmod_factorize(&matrix, factor, &common.settings) || !is_positive_definite(*factor)) {
      release();
      throw std::runtime_error(
          "the matrix is not positive definite: no film leads to an environment, or a body is free to move");
    }
  }
  ~Impl() { release(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void release() {
    cholmod_free_dense(&solution, &common.settings);
    cholmod_free_dense(&workspace_y, &common.settings);
    cholmod_free_dense(&workspace_e, &common.settings);
    cholmod_free_factor(&factor, &common.settings);
  }

  CholeskyAnalysis analysis;
  Common common;
  cholmod_factor* factor = nullptr;
  cholmod_dense* solution = nullptr;
  cholmod_dense* workspace_y = nullptr;
  cholmod_dense* workspace_e = nullptr;
};

CholeskyFactor::CholeskyFactor(const SparseMatrix& lower, Solutions wanted)
    : impl_(std::make_unique<Impl>(CholeskyAnalysis(lower, wanted), lower, wanted)) {}

CholeskyFactor::CholeskyFactor(const CholeskyAnalysis& analysis, const SparseMatrix& lower)
    : impl_(std::make_unique<Impl>(analysis, lower, Solutions::many)) {}

CholeskyFactor::~CholeskyFactor() = default;
CholeskyFactor::CholeskyFactor(CholeskyFactor&&) noexcept = default;
CholeskyFactor& CholeskyFactor::operator=(CholeskyFactor&&) noexcept = default;

const CholeskyAnalysis& CholeskyFactor::analysis() const { return impl_->analysis; }

void CholeskyFactor::solve(const double* loads, Eigen::Index columns, double* solutions) {
  if (columns == 0) return;
  cholmod_dense given = view_of(loads, static_cast<Eigen::Index>(impl_->factor->n), columns);
  if (!cholmod_solve2(CHOLMOD_A, impl_->factor, &given, nullptr, &impl_->solution, nullptr, &impl_->workspace_y,
                      &impl_->workspace_e, &impl_->common.settings)) {
    throw std::runtime_error("CHOLMOD could not solve");
  }
  std::copy_n(static_cast<const double*>(impl_->solution->x), given.nzmax, solutions);
}

void CholeskyFactor::solve(const Eigen::VectorXd& right_hand_side, Eigen::VectorXd& solution) {
  solution.resize(right_hand_side.size());
  solve(right_hand_side.data(), 1, solution.data());
}

Eigen::MatrixXd CholeskyFactor::solve(const Eigen::MatrixXd& right_hand_sides) {
  Eigen::MatrixXd solutions(right_hand_sides.rows(), right_hand_sides.cols());
  solve(right_hand_sides.data(), right_hand_sides.cols(), solutions.data());
  return solutions;
}

}  // namespace spindle_twin::fem_offline

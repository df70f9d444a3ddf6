#include <malloc.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "fem_offline/reduce/analysed_system.hpp"
#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/column_store.hpp"
#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/full_histories.hpp"
#include "fem_offline/reduce/most_independent.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "fem_offline/sparse/cholesky.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double full_corner_share = 0.4;
constexpr double steady_share = 0.25;
constexpr double shift_low_per_s = 2e-4;
constexpr double shift_high_per_s = 3.0;

Eigen::VectorXd nominal_conductances(const rom::Boundaries& boundaries) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(boundaries.conductances.size()));
  for (Eigen::Index j = 0; j < values.size(); ++j) {
    values[j] = boundaries.conductances[static_cast<std::size_t>(j)].nominal_W_per_m2K;
  }
  return values;
}

/// One worker's matrices and the symbolic analysis that all its factors share.
struct Worker : AnalysedSystem {
  using AnalysedSystem::AnalysedSystem;

  /// (K + sC)⁻¹ F; with s > 0 as s⁻¹ (C + K/s)⁻¹ F.
  Eigen::MatrixXd solve(const Eigen::VectorXd& conductances, double shift_per_s, const Eigen::MatrixXd& loads) {
    system.hold_conductances(conductances);
    const ThermalSystem& matrices = system.matrices();
    const bool steady = shift_per_s == 0.0;
    CholeskyFactor factor(analysed, steady ? matrices.conduction_lower() : matrices.combined_lower(1.0 / shift_per_s));
    Eigen::MatrixXd solutions = factor.solve(loads);
    if (!steady) solutions /= shift_per_s;
    return solutions;
  }

  /// Solutions for all loads at one random set.
  Eigen::MatrixXd responses(const AffineModel& model, const Loads& loads, const ReduceOptions& options,
                            std::uint32_t set) {
    RandomStream random(options.seed, StreamPurpose::full_snapshots, set);
    const bool corner = random.uniform(0.0, 1.0) < full_corner_share;
    const bool steady = random.uniform(0.0, 1.0) < steady_share;
    const double shift_per_s = random.log_uniform(shift_low_per_s, shift_high_per_s);
    const Eigen::VectorXd conductances = random_conductances(model.boundaries, options.box, corner, random);
    const Eigen::MatrixXd primal = loads.primal(conductances);
    Eigen::MatrixXd right_hand_sides(primal.rows(), primal.cols() + loads.outputs.cols());
    right_hand_sides << primal, loads.outputs;
    return solve(conductances, steady ? 0.0 : shift_per_s, right_hand_sides);
  }
};

void scale_outputs(Worker& worker, const AffineModel& model, const ReduceOptions& options, Loads& loads) {
  const Eigen::VectorXd conductances = nominal_conductances(model.boundaries);
  Eigen::MatrixXd primal = worker.solve(conductances, 0.0, loads.primal(conductances));
  Eigen::MatrixXd dual = worker.solve(conductances, 0.0, loads.outputs);
  remove_constant(primal);
  remove_constant(dual);
  const double size = primal.colwise().norm().mean();
  const auto growth_at = static_cast<Eigen::Index>(model.key_points.size());
  const auto pressures_at = growth_at + static_cast<Eigen::Index>(model.deformations.size());
  for (Eigen::Index i = 0; i < dual.cols(); ++i) {
    const double weight = i < growth_at      ? options.dual_weight
                          : i < pressures_at ? options.growth_dual_weight
                                             : options.pressure_dual_weight;
    const double own = dual.col(i).norm();
    if (own > 0.0) loads.outputs.col(i) *= weight * size / own;
  }
}

/// Lower triangle of XᵀX by tiles, and nothing above but in the diagonal's tiles; every tile is one product, so the
/// bits do not depend on the number of threads.
Eigen::MatrixXd gram_matrix(const Eigen::MatrixXd& columns, int threads) {
  constexpr Eigen::Index tile = 256;
  const Eigen::Index count = columns.cols();
  const int tiles = static_cast<int>((count + tile - 1) / tile);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count, count);
  for_each_index(tiles, threads, [&](int index, int) {
    const int row = tiles - 1 - index;  // the longest first
    const Eigen::Index r = row * tile, height = std::min(tile, count - r);
    for (int column = 0; column <= row; ++column) {
      const Eigen::Index c = column * tile, width = std::min(tile, count - c);
      gram.block(r, c, height, width) = transposed_product(columns.middleCols(r, height), columns.middleCols(c, width));
    }
  });
  return gram;
}

/// Columns times the inverse of the Cholesky factor of their own Gram matrix; a second pass mends what the squared
/// condition number of the first one costs.
void orthonormalise(Eigen::MatrixXd& columns, int threads) {
  constexpr Eigen::Index rows_per_block = 2048;
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::MatrixXd gram = gram_matrix(columns, threads);
    if (pass == 0) gram.diagonal() *= 1.0 + 1e-14;
    const Eigen::LLT<Eigen::MatrixXd> root(gram);
    if (root.info() != Eigen::Success) {
      throw std::runtime_error("of the " + std::to_string(gram.cols()) +
                               " snapshots that the basis is made of some depend on others");
    }
    const Eigen::MatrixXd upper = root.matrixU();
    const int blocks = static_cast<int>((columns.rows() + rows_per_block - 1) / rows_per_block);
    for_each_index(blocks, threads, [&](int block, int) {
      const Eigen::Index first = block * rows_per_block;
      const Eigen::Index height = std::min(rows_per_block, columns.rows() - first);
      Eigen::MatrixXd part = columns.middleRows(first, height);
      divide_by_upper(part, upper);
      columns.middleRows(first, height) = part;
    });
  }
}

/// Orthonormal columns that, with the constant vector, span the functions that are 1 on one part or air volume and 0
/// elsewhere; none where that would take all nodes.
Eigen::MatrixXd body_columns(const AffineModel& model, int nodes) {
  const Eigen::Index unknowns = model.capacity_J_per_K.rows();
  const auto air = static_cast<Eigen::Index>(model.air_names.size());
  const auto bodies = static_cast<Eigen::Index>(model.parts.size()) + air;
  if (bodies >= nodes) return Eigen::MatrixXd(unknowns, 0);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(unknowns, bodies);
  for (std::size_t part = 0; part < model.parts.size(); ++part) {
    for (const int dof : model.parts[part].dofs) columns(dof, static_cast<Eigen::Index>(part)) = 1.0;
  }
  columns.bottomRightCorner(air, air).setIdentity();
  // The smallest body goes: the others and the constant give it back.
  Eigen::Index smallest = 0;
  columns.colwise().sum().minCoeff(&smallest);
  columns.col(smallest).swap(columns.col(bodies - 1));
  Eigen::MatrixXd others = columns.leftCols(bodies - 1);
  remove_constant(others);
  const Eigen::HouseholderQR<Eigen::MatrixXd> factor(others);
  return factor.householderQ() * Eigen::MatrixXd::Identity(unknowns, bodies - 1);
}

/// Solutions for every load at options.full_sets sets, then the fields of options.full_histories histories, without
/// what the constant and `bodies` span of them.
std::unique_ptr<ColumnStore<float>> full_snapshots(const AffineModel& model, const Loads& loads,
                                                   const Eigen::MatrixXd& bodies, const ReduceOptions& options,
                                                   std::vector<Worker>& workers, const Progress& progress) {
  const int response_sets = options.full_sets, items = response_sets + options.full_histories;
  std::vector<History> histories;
  histories.reserve(static_cast<std::size_t>(options.full_histories));
  for (int i = 0; i < options.full_histories; ++i) {
    histories.push_back(
        random_history(model.boundaries, options, StreamPurpose::full_histories, static_cast<std::uint32_t>(i)));
  }
  const Eigen::Index responses = loads.primal(nominal_conductances(model.boundaries)).cols() + loads.outputs.cols();
  std::vector<Eigen::Index> first(1, 0);  // column of every item, and their number
  for (int item = 0; item < items; ++item) {
    first.push_back(first.back() + (item < response_sets
                                        ? responses
                                        : histories[static_cast<std::size_t>(item - response_sets)].fields()));
  }
  auto snapshots = std::make_unique<ColumnStore<float>>(model.capacity_J_per_K.rows(), first.back());
  std::atomic<int> finished{0};
  for_each_index(items, options.threads, [&](int item, int index) {
    Worker& worker = workers[static_cast<std::size_t>(index)];
    Eigen::MatrixXd own = item < response_sets
                              ? worker.responses(model, loads, options, static_cast<std::uint32_t>(item))
                              : full_history(model, worker, histories[static_cast<std::size_t>(item - response_sets)]);
    remove_constant(own);
    for (int pass = 0; pass < 2; ++pass) own -= product(bodies, transposed_product(bodies, own));
    snapshots->write(first[static_cast<std::size_t>(item)], own);
    const int done = ++finished;
    if (index == 0 && progress) progress("FE snapshots", static_cast<double>(done) / items);
  });
  return snapshots;
}

}  // namespace

RichBasis full_snapshot_basis(const AffineModel& model, Loads& loads, const ReduceOptions& options,
                              const Progress& progress) {
  const int items = options.full_sets + options.full_histories;
  std::vector<Worker> workers(static_cast<std::size_t>(std::clamp(options.threads, 1, items)), Worker(model));
  scale_outputs(workers.front(), model, options, loads);
  const Eigen::Index unknowns = model.capacity_J_per_K.rows();
  const Eigen::MatrixXd bodies = body_columns(model, options.nodes);
  auto snapshots = full_snapshots(model, loads, bodies, options, workers, progress);
  workers = {};
  malloc_trim(0);  // the factors' memory

  const Eigen::Index of_bodies =
      options.rich_states_per_body * (static_cast<int>(model.parts.size() + model.air_names.size()));
  const Eigen::Index most = std::min(std::max<Eigen::Index>(options.rich_states, of_bodies), unknowns);
  const std::vector<int> chosen = most_independent(*snapshots, most - 1 - bodies.cols(), options.threads);
  const Eigen::Index count = static_cast<Eigen::Index>(chosen.size());

  RichBasis basis;
  basis.snapshots = static_cast<int>(snapshots->cols());
  Eigen::MatrixXd kept = snapshots->chosen(chosen);
  snapshots.reset();
  kept.colwise().normalize();
  remove_constant(kept);  // what rounding to single precision has brought back
  kept -= product(bodies, transposed_product(bodies, kept));
  orthonormalise(kept, options.threads);
  basis.columns.resize(unknowns, count + 1 + bodies.cols());
  basis.columns.middleCols(1, bodies.cols()) = bodies;
  basis.bodies = static_cast<int>(bodies.cols()) + 1;
  basis.columns.col(0).setConstant(1.0 / std::sqrt(static_cast<double>(unknowns)));
  basis.columns.rightCols(count) = kept;
  return basis;
}

}  // namespace spindle_twin::fem_offline

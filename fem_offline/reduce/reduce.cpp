#include "fem_offline/reduce/reduce.hpp"

#include <malloc.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/column_store.hpp"
#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/loads.hpp"
#include "fem_offline/reduce/nodal.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "fem_offline/reduce/stage_clock.hpp"

namespace spindle_twin::fem_offline {
namespace {

void check_options(const AffineModel& model, const ReduceOptions& options) {
  const Eigen::Index unknowns = model.capacity_J_per_K.rows();
  if (options.nodes < 2 || options.nodes > unknowns) {
    throw std::invalid_argument("nodes: " + std::to_string(options.nodes) + " is outside 2 to " +
                                std::to_string(unknowns) + ", the unknowns of the FE model");
  }
  if (options.full_sets < 1 || options.full_histories < 0 || options.rich_sets < 1 || options.rich_states < 2 ||
      options.threads < 1) {
    throw std::invalid_argument(
        "full_sets, rich_sets and threads must be at least 1, rich_states at least 2, full_histories at least 0");
  }
}

/// R becomes R U, by blocks of rows. U is square.
void combine(Eigen::MatrixXd& rich, const Eigen::MatrixXd& coordinates, int threads) {
  constexpr Eigen::Index rows_per_block = 1024;
  const int blocks = static_cast<int>((rich.rows() + rows_per_block - 1) / rows_per_block);
  for_each_index(blocks, threads, [&](int block, int) {
    const Eigen::Index first = block * rows_per_block;
    auto rows = rich.middleRows(first, std::min(rows_per_block, rich.rows() - first));
    rows = product(Eigen::MatrixXd(rows), coordinates);
  });
}

}  // namespace

struct Reduction::Impl {
  const AffineModel* model;
  ReduceOptions options;
  int bodies = 1;                              ///< as in RichBasis
  std::unique_ptr<ColumnStore<double>> basis;  ///< nested; only those columns are in memory that a network asks for

  /// The first ones. Throws std::invalid_argument where there are not so many.
  Eigen::MatrixXd columns(int nodes) const;
};

Reduction::Reduction(const AffineModel& model, const ReduceOptions& options, const Progress& progress,
                     ReduceReport* report)
    : impl_(std::make_unique<Impl>(Impl{&model, options, 1, nullptr})) {
  check_options(model, options);
  StageClock clock(report, progress);
  Loads loads = make_loads(model, options.box.speed_high_rpm, options.box.load_high);
  RichBasis basis = full_snapshot_basis(model, loads, options, progress);
  const Eigen::Index unknowns = basis.columns.rows(), states = basis.columns.cols();
  impl_->bodies = basis.bodies;
  clock.finish("FE snapshots");
  RichModel rich = project_model(model, loads, basis.columns, options.threads);
  rich.bodies = basis.bodies;
  clock.finish("projection");
  const RichSnapshots snapshots = rich_snapshots(rich, model.boundaries, options, progress);
  rich.dense.conductance_terms = PackedTerms();
  clock.finish("network snapshots");
  combine(basis.columns, network_basis(rich, snapshots, options.threads), options.threads);
  impl_->basis = std::make_unique<ColumnStore<double>>(unknowns, states);
  for (Eigen::Index column = 0; column < states; ++column) impl_->basis->write(column, basis.columns.col(column));
  clock.finish("network basis");
  if (report == nullptr) return;
  report->full_unknowns = static_cast<int>(unknowns);
  report->snapshots = basis.snapshots;
  report->rich_states = static_cast<int>(states);
}

Reduction::~Reduction() = default;
Reduction::Reduction(Reduction&&) noexcept = default;
Reduction& Reduction::operator=(Reduction&&) noexcept = default;

int Reduction::most_nodes() const { return static_cast<int>(impl_->basis->cols()); }

Eigen::MatrixXd Reduction::Impl::columns(int nodes) const {
  if (nodes < 2 || nodes > basis->cols()) {
    throw std::invalid_argument("nodes: outside 2 to " + std::to_string(basis->cols()));
  }
  return basis->block(0, nodes);
}

DenseModel Reduction::dense_model(int nodes) const {
  DenseModel result = project_dense(*impl_->model, impl_->columns(nodes), impl_->options.threads);
  malloc_trim(0);
  return result;
}

PartExtremes Reduction::part_extremes(const DenseModel& model) const {
  const Eigen::MatrixXd basis = impl_->columns(static_cast<int>(model.capacity.rows()));
  PartExtremes extremes = find_part_extremes(*impl_->model, basis, model, impl_->options);
  malloc_trim(0);
  return extremes;
}

OutputRows Reduction::output_rows(int nodes, const PartExtremes& extremes) const {
  return project_output_rows(*impl_->model, impl_->columns(nodes), extremes);
}

rom::Network Reduction::network(int nodes, ReduceReport* report, const Progress& progress, PartExtremes* known) const {
  const AffineModel& model = *impl_->model;
  const int threads = impl_->options.threads;
  StageClock clock(report, progress);
  rom::Network network;
  network.spindle = model.spindle;
  network.description_hash = model.description_hash;
  network.boundaries = model.boundaries;
  NodalCoordinates nodal;
  {
    const Eigen::MatrixXd basis = impl_->columns(nodes);
    nodal = choose_nodes(basis, threads);
    clock.finish("nodes");
    project_network(model, basis, impl_->bodies, nodal, threads, network);
  }
  if (report) report->condition = nodal.condition;
  project_outputs(model, nodal, network);
  clock.finish("network");

  PartExtremes extremes = known ? *known : PartExtremes();
  if (extremes.empty()) {
    extremes = find_part_extremes(model, nodal.interpolant, dense_model_of(network), impl_->options);
  }
  add_part_extremes(model, nodal, extremes, network);
  if (known) *known = std::move(extremes);
  clock.finish("part extremes");
  malloc_trim(0);  // what the choice of nodes took
  return network;
}

rom::Network reduce_model(const AffineModel& model, const ReduceOptions& options, const Progress& progress,
                          ReduceReport* report) {
  check_options(model, options);
  const Reduction reduction(model, options, progress, report);
  return reduction.network(std::min(options.nodes, reduction.most_nodes()), report, progress);
}

}  // namespace spindle_twin::fem_offline

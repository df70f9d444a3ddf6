#include "fem_offline/reduce/reduce.hpp"

#include <malloc.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "fem_offline/reduce/basis.hpp"
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

/// V = R U by blocks of rows.
Eigen::MatrixXd combine(const Eigen::MatrixXd& rich, const Eigen::MatrixXd& coordinates, int threads) {
  constexpr Eigen::Index rows_per_block = 1024;
  Eigen::MatrixXd combined(rich.rows(), coordinates.cols());
  const int blocks = static_cast<int>((rich.rows() + rows_per_block - 1) / rows_per_block);
  for_each_index(blocks, threads, [&](int block, int) {
    const Eigen::Index first = block * rows_per_block;
    const Eigen::Index height = std::min(rows_per_block, rich.rows() - first);
    combined.middleRows(first, height) = product(rich.middleRows(first, height), coordinates);
  });
  return combined;
}

}  // namespace

struct Reduction::Impl {
  const AffineModel* model;
  ReduceOptions options;
  RichBasis full;
  RichModel rich;
  Eigen::MatrixXd coordinates;  ///< of the nested basis, in the rich one
};

Reduction::Reduction(const AffineModel& model, const ReduceOptions& options, const Progress& progress,
                     ReduceReport* report)
    : impl_(std::make_unique<Impl>(Impl{&model, options, {}, {}, {}})) {
  check_options(model, options);
  StageClock clock(report, progress);
  Loads loads = make_loads(model, options.box.speed_high_rpm, options.box.load_high);
  impl_->full = full_snapshot_basis(model, loads, options, progress);
  clock.finish("FE snapshots");
  impl_->rich = project_model(model, loads, impl_->full.columns, options.threads);
  impl_->rich.bodies = impl_->full.bodies;
  clock.finish("projection");
  const RichSnapshots snapshots = rich_snapshots(impl_->rich, model.boundaries, options, progress);
  clock.finish("network snapshots");
  impl_->coordinates = network_basis(impl_->rich, snapshots, options.threads);
  clock.finish("network basis");
  if (report == nullptr) return;
  report->full_unknowns = static_cast<int>(model.capacity_J_per_K.rows());
  report->snapshots = impl_->full.snapshots;
  report->rich_states = static_cast<int>(impl_->full.columns.cols());
}

Reduction::~Reduction() = default;
Reduction::Reduction(Reduction&&) noexcept = default;
Reduction& Reduction::operator=(Reduction&&) noexcept = default;

int Reduction::most_nodes() const { return static_cast<int>(impl_->coordinates.cols()); }

rom::Network Reduction::network(int nodes, ReduceReport* report, const Progress& progress, PartExtremes* known) const {
  if (nodes < 2 || nodes > most_nodes()) {
    throw std::invalid_argument("nodes: outside 2 to " + std::to_string(most_nodes()));
  }
  const AffineModel& model = *impl_->model;
  const int threads = impl_->options.threads;
  StageClock clock(report, progress);
  const Eigen::MatrixXd coordinates = impl_->coordinates.leftCols(nodes);
  const NodalCoordinates nodal = choose_nodes(combine(impl_->full.columns, coordinates, threads), threads);
  if (report) report->condition = nodal.condition;
  clock.finish("nodes");

  rom::Network network;
  network.spindle = model.spindle;
  network.description_hash = model.description_hash;
  network.boundaries = model.boundaries;
  project_network(impl_->rich, coordinates, model, nodal, threads, network);
  project_outputs(model, nodal, network);
  clock.finish("network");

  PartExtremes extremes = known ? *known : PartExtremes();
  if (extremes.empty()) extremes = find_part_extremes(model, nodal, impl_->options, network);
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

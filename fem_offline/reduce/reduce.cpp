#include "fem_offline/reduce/reduce.hpp"

#include <chrono>
#include <stdexcept>

#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/loads.hpp"
#include "fem_offline/reduce/nodal.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

void check_options(const AffineModel& model, const ReduceOptions& options) {
  const Eigen::Index unknowns = model.capacity_J_per_K.rows();
  if (options.nodes < 2 || options.nodes > unknowns) {
    throw std::invalid_argument("nodes: " + std::to_string(options.nodes) + " is outside 2 to " +
                                std::to_string(unknowns) + ", the unknowns of the FE model");
  }
  if (options.full_sets < 1 || options.rich_sets < 1 || options.rich_states < 2 || options.threads < 1) {
    throw std::invalid_argument("full_sets, rich_sets and threads must be at least 1, rich_states at least 2");
  }
}

/// V = R U by blocks of rows.
Eigen::MatrixXd combine(const Eigen::MatrixXd& rich, const Eigen::MatrixXd& coordinates, int threads) {
  constexpr Eigen::Index rows_per_block = 1024;
  Eigen::MatrixXd product(rich.rows(), coordinates.cols());
  const int blocks = static_cast<int>((rich.rows() + rows_per_block - 1) / rows_per_block);
  for_each_index(blocks, threads, [&](int block, int) {
    const Eigen::Index first = block * rows_per_block;
    const Eigen::Index height = std::min(rows_per_block, rich.rows() - first);
    product.middleRows(first, height).noalias() = rich.middleRows(first, height) * coordinates;
  });
  return product;
}

}  // namespace

rom::Network reduce_model(const AffineModel& model, const ReduceOptions& options, const Progress& progress,
                          ReduceReport* report) {
  check_options(model, options);
  ReduceReport unused;
  ReduceReport& out = report != nullptr ? *report : unused;
  out = {};
  out.full_unknowns = static_cast<int>(model.capacity_J_per_K.rows());
  using Clock = std::chrono::steady_clock;
  auto started = Clock::now();
  const auto finish = [&](const std::string& stage) {
    const auto now = Clock::now();
    out.stages.push_back({stage, std::chrono::duration<double>(now - started).count()});
    started = now;
    if (progress) progress(stage, 1.0);
  };

  Loads loads = make_loads(model, options.box.speed_high_rpm, options.box.load_high);
  RichBasis full = full_snapshot_basis(model, loads, options, progress);
  out.snapshots = full.snapshots;
  out.rich_states = static_cast<int>(full.columns.cols());
  finish("FE snapshots");

  RichModel rich = project_model(model, loads, full.columns, options.threads);
  rich.bodies = full.bodies;
  finish("projection");

  const Eigen::MatrixXd coordinates = rich_snapshot_basis(rich, model.boundaries, options, progress);
  finish("network snapshots");

  const NodalCoordinates nodal = choose_nodes(combine(full.columns, coordinates, options.threads));
  full.columns.resize(0, 0);
  out.condition = nodal.condition;
  finish("nodes");

  rom::Network network;
  network.spindle = model.spindle;
  network.description_hash = model.description_hash;
  network.boundaries = model.boundaries;
  project_network(rich, coordinates, model, nodal, options.threads, network);
  project_outputs(model, nodal, network);
  finish("network");

  choose_candidates(model, nodal, options, network);
  finish("part extremes");
  return network;
}

}  // namespace spindle_twin::fem_offline

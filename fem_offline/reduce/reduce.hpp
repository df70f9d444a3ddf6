#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/dense_model.hpp"
#include "fem_offline/reduce/output_rows.hpp"
#include "fem_offline/reduce/parameter_box.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

struct ReduceOptions {
  int nodes = 160;
  std::uint64_t seed = 1;
  int threads = 2;
  int full_sets = 60;                  ///< random parameter sets at which the FE model is solved
  int full_histories = 120;            ///< random histories with jumps that the FE model goes through
  int rich_states = 460;               ///< least size of the richer Galerkin model between FE model and network
  int rich_states_per_body = 20;       ///< its size for each part and air volume, where that is more
  int rich_sets = 1000;                ///< random parameter sets at which the richer model is solved
  double dual_weight = 0.3;            ///< size of the adjoint snapshots of key points relative to the primal ones
  double growth_dual_weight = 0.6;     ///< the same of deformations
  double pressure_dual_weight = 0.03;  ///< the same of contact pressures
  ParameterBox box;
};

struct StageTime {
  std::string stage;
  double seconds = 0.0;      ///< by the clock on the wall
  double processor_s = 0.0;  ///< of all threads
};

struct ReduceReport {
  int full_unknowns = 0;
  int snapshots = 0;
  int rich_states = 0;
  /// Of the orthonormal basis at the nodes; below 100 the node temperatures are good coordinates.
  double condition = 0.0;
  std::vector<StageTime> stages;
};

/// Called with the stage's name and the fraction of it that is done; from one thread at a time.
using Progress = std::function<void(const std::string& stage, double fraction)>;

/// The nested basis of an FE model: its first N columns span the network of N nodes.
class Reduction {
 public:
  /// Solves the FE model and the richer model between FE model and network at random parameter sets.
  /// Throws std::invalid_argument for options out of range, std::runtime_error when K is not positive definite.
  Reduction(const AffineModel& model, const ReduceOptions& options, const Progress& progress = {},
            ReduceReport* report = nullptr);
  ~Reduction();
  Reduction(Reduction&&) noexcept;
  Reduction& operator=(Reduction&&) noexcept;

  /// Most nodes that network() can give.
  int most_nodes() const;

  /// Nodal RC network of the FE model by Galerkin projection T ≈ V T_nodes on one fixed basis that serves the whole
  /// box:
  ///   C = VᵀC V,  K₀ = VᵀK₀V,  FⱼFⱼᵀ = VᵀKⱼV,  B = VᵀB,  rows y = y V
  /// with V(node i, :) = eᵢ and V 1 = 1, so that state i is the temperature of node i and heat is conserved to
  /// rounding. The same seed gives the same bits whatever the number of threads. The certificate stays empty.
  /// `nodes` in [2, most_nodes()], else std::invalid_argument. To seek the points of part extremes takes long; a search
  /// for a size gives `known` ones: sought when empty, and otherwise those of another size.
  rom::Network network(int nodes, ReduceReport* report = nullptr, const Progress& progress = {},
                       PartExtremes* known = nullptr) const;

  /// What a search for a size needs of network(nodes), in the coordinates of the basis, since a choice of nodes would
  /// take longer than all the rest. The model on fewer nodes is the part of it that first_states gives. `nodes` as
  /// above, here and below.
  DenseModel dense_model(int nodes) const;
  /// The points of part extremes that network(nodes) would seek, `model` being dense_model(nodes).
  PartExtremes part_extremes(const DenseModel& model) const;
  OutputRows output_rows(int nodes, const PartExtremes& extremes) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Reduction and its network of options.nodes in one call; options.nodes must be in [2, unknowns]; fewer come out when
/// the snapshots span fewer directions. `report` gets its stages behind those that it has.
rom::Network reduce_model(const AffineModel& model, const ReduceOptions& options, const Progress& progress = {},
                          ReduceReport* report = nullptr);

}  // namespace spindle_twin::fem_offline

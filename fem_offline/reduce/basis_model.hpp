#pragma once

#include "fem_offline/reduce/dense_model.hpp"
#include "fem_offline/reduce/output_rows.hpp"

namespace spindle_twin::fem_offline {

/// A network in the coordinates of its basis, before nodes are chosen: its temperatures and outputs are those of the
/// network with any choice of nodes, but for rounding.
struct BasisModel {
  DenseModel dense;
  OutputRows outputs;
};

}  // namespace spindle_twin::fem_offline

#pragma once

#include <Eigen/Core>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// A network in coordinates z, T = Φ z, in which it is diagonal as long as its conductances are those that it was made
/// for: ΦᵀCΦ = 1, ΦᵀKΦ = diag(rates).
struct ModalForm {
  rom::Network network;         ///< capacity 1, conduction diag(rates); sources, factors and output rows in z
  Eigen::VectorXd rates_per_s;  ///< rising
  Eigen::VectorXd uniform;      ///< z of the field that is 1 K everywhere
};

/// Eigenvectors of (K, C), K = K₀ + Σ gⱼ FⱼFⱼᵀ with these conductances, W/m²K, one for each of the network.
/// std::runtime_error where C is not positive definite.
ModalForm modal_form(const rom::Network& network, const Eigen::VectorXd& conductance_W_per_m2K);

}  // namespace spindle_twin::host_tools

#pragma once

#include <Eigen/Core>
#include <memory>

#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::rom {

/// Steady sensitivities of an output y = row · (T − T_ref) by one adjoint solution. With f(x, g, q) = 0 the steady
/// state in internal coordinates (integrate/right_hand_side.hpp) and A = −∂f/∂x:
///   Aᵀ λ = L⁻¹ row        dy / d ln gⱼ = λᵀ ∂f / ∂ ln gⱼ        dy / d ln qᵢ = λᵀ ∂f / ∂ ln qᵢ
/// ∂f / ∂ ln gⱼ is a difference quotient, exact to rounding as f is affine in g (along a coolant circuit, where gⱼ also
/// moves the liquid downstream, to 1e-6). gⱼ of a segment is the effective one of the channel law.
struct SteadySensitivities {
  Eigen::VectorXd conductance;  ///< dy / d ln gⱼ, in the unit of y
  Eigen::VectorXd heat;         ///< dy / d ln qᵢ
};

/// `temperatures_K`: the steady state of `values` (steady_temperatures_K). Not for the cycle.
SteadySensitivities steady_sensitivities(const std::shared_ptr<const NetworkOperator>& coordinates,
                                         const BoundaryValues& values, const Eigen::VectorXd& temperatures_K,
                                         const Eigen::VectorXd& row);

}  // namespace spindle_twin::rom

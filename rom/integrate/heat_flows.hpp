#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "rom/network.hpp"

namespace spindle_twin::rom {

/// A part, or an air volume, as one side of the heat flows.
struct Body {
  std::string name;
  std::vector<Eigen::Index> nodes;
};

/// The parts that have nodes, in the network's order, then every node that belongs to no part.
std::vector<Body> network_bodies(const Network& network);

/// One way of heat: through a contact or film, from a body to another one or to the environment that a film meets.
struct FlowPath {
  Eigen::Index conductance = 0;
  Eigen::Index from = 0;   ///< body; its heat by this conductance (HeatFlows::exchange_W) is the path's
  Eigen::Index to = -1;    ///< body; -1: the conductance's environment
  bool has_place = false;  ///< whether it acts somewhere on the section, at [r_m, z_m]
  double r_m = 0.0, z_m = 0.0;
};

/// Every exchange as paths, in the order of the conductances. Where more than two bodies take part in one of them one
/// is the hub: an air volume, which has all the area of the others. The place is the mean of the nodes of the bodies at
/// both ends, by the squares of their factors. Allocates; not for the cycle.
std::vector<FlowPath> flow_paths(const Network& network, const std::vector<Body>& bodies);

/// Heat that each body gives and takes at one instant, W. With 1_A the vector that is 1 at the nodes of body A:
///   exchange(A, j) = gⱼ 1_Aᵀ Fⱼ Fⱼᵀ (T − 1 T_env(j))      what A loses by contact or film j
///   conduction(A)  = 1_Aᵀ K₀ T                            what A loses to other bodies without a contact
///   source(A, i)   = 1_Aᵀ B qᵢ
///   node(A)        = 1_Aᵀ node heat
///   stored(A)      = 1_Aᵀ C dT/dt = Σᵢ source + node − conduction − Σⱼ exchange, C with its capacity factors
/// for a segment of a coolant circuit T_env is the temperature of the liquid that enters it. The columns of `exchange`
/// between bodies sum to zero, and conduction does. Built networks have a function per body in their basis: there
/// conduction is rounding, and a contact between two bodies leaves nothing with any other.
struct HeatFlows {
  Eigen::MatrixXd exchange_W;    ///< bodies x conductances
  Eigen::VectorXd conduction_W;  ///< bodies
  Eigen::MatrixXd source_W;      ///< bodies x sources
  Eigen::VectorXd node_W;        ///< bodies; BoundaryValues::node_heat_W, 0 where there is none
  Eigen::VectorXd stored_W;      ///< bodies
};

/// At these node temperatures and inputs. Allocates; not for the cycle.
HeatFlows heat_flows(const Network& network, const std::vector<Body>& bodies, const BoundaryValues& values,
                     const Eigen::VectorXd& temperatures_K);

}  // namespace spindle_twin::rom

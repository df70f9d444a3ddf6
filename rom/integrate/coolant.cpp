#include "rom/integrate/coolant.hpp"

#include <cmath>

namespace spindle_twin::rom {
namespace {

/// Calls visit(segment, G) in the order of the flow.
template <class Visit>
void along_flow(const CoolantSegments& segments, const BoundaryValues& values, std::size_t circuit, Visit visit) {
  const int begin = segments.first[circuit], end = segments.first[circuit + 1];
  const bool backwards = values.coolant_W_per_K[static_cast<Eigen::Index>(circuit)] < 0.0;
  for (int i = begin; i < end; ++i) {
    const int segment = backwards ? end - 1 - (i - begin) : i;
    const int conductance = segments.conductance[static_cast<std::size_t>(segment)];
    visit(segment, values.conductance_W_per_m2K[conductance] * segments.area_m2[segment]);
  }
}

}  // namespace

CoolantSegments coolant_segments(const Boundaries& boundaries) {
  CoolantSegments segments;
  segments.first.push_back(0);
  for (const CoolantCircuit& circuit : boundaries.circuits) {
    for (const int conductance : circuit.segments) {
      segments.conductance.push_back(conductance);
      segments.inlet.push_back(circuit.environment);
    }
    segments.first.push_back(static_cast<int>(segments.conductance.size()));
  }
  segments.area_m2.resize(segments.count());
  for (Eigen::Index s = 0; s < segments.count(); ++s) {
    const auto conductance = static_cast<std::size_t>(segments.conductance[static_cast<std::size_t>(s)]);
    segments.area_m2[s] = boundaries.conductances[conductance].area_m2;
  }
  return segments;
}

void coolant_upstream(const CoolantSegments& segments, const BoundaryValues& values, Eigen::MatrixXd& upstream) {
  upstream.setZero();
  for (std::size_t c = 0; c + 1 < segments.first.size(); ++c) {
    const double flow_W_per_K = std::abs(values.coolant_W_per_K[static_cast<Eigen::Index>(c)]);
    int before = -1;
    double share_before = 0.0;  // of the way from the liquid's temperature to the wall's that the segment before goes
    along_flow(segments, values, c, [&](int segment, double heat_W_per_K) {
      if (before >= 0) {
        upstream.row(segment) = (1.0 - share_before) * upstream.row(before);
        upstream(segment, before) += share_before;
      }
      before = segment;
      share_before = flow_W_per_K > 0.0 ? heat_W_per_K / flow_W_per_K : 1.0;
    });
  }
}

void coolant_slope(const CoolantSegments& segments, const BoundaryValues& values, const Eigen::VectorXd& wall_rise_K,
                   std::size_t circuit, int changed, Eigen::VectorXd& weights) {
  weights.setZero();
  const double flow_W_per_K = std::abs(values.coolant_W_per_K[static_cast<Eigen::Index>(circuit)]);
  if (!(flow_W_per_K > 0.0)) return;
  double rise_K = 0.0, rise_slope = 0.0;
  along_flow(segments, values, circuit, [&](int segment, double heat_W_per_K) {
    const double area_m2 = segments.area_m2[segment], share = heat_W_per_K / flow_W_per_K;
    weights[segment] = rise_slope * heat_W_per_K / area_m2;
    rise_slope *= 1.0 - share;
    if (segment == changed) {
      weights[segment] += rise_K;
      rise_slope += area_m2 / flow_W_per_K * (wall_rise_K[segment] - rise_K);
    }
    rise_K += share * (wall_rise_K[segment] - rise_K);
  });
}

void march_coolant(const CoolantSegments& segments, const BoundaryValues& values, const Eigen::VectorXd& wall_K,
                   CoolantOutlets& outlets) {
  for (std::size_t c = 0; c + 1 < segments.first.size(); ++c) {
    const auto circuit = static_cast<Eigen::Index>(c);
    const double flow_W_per_K = std::abs(values.coolant_W_per_K[circuit]);
    // Every circuit has a segment.
    const int inlet = segments.inlet[static_cast<std::size_t>(segments.first[c])];
    // Rises above the inlet: what they lose to rounding is theirs, not that of three hundred kelvin.
    double rise_K = 0.0, heat_W = 0.0;
    along_flow(segments, values, c, [&](int segment, double heat_W_per_K) {
      const double above_K = wall_K[segment] - values.environment_K[inlet] - rise_K;
      heat_W += heat_W_per_K * above_K;
      rise_K += flow_W_per_K > 0.0 ? heat_W_per_K / flow_W_per_K * above_K : above_K;
    });
    outlets.outlet_K[circuit] = values.environment_K[inlet] + rise_K;
    outlets.heat_W[circuit] = heat_W;
  }
}

}  // namespace spindle_twin::rom

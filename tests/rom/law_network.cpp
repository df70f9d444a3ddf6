#include "tests/rom/law_network.hpp"

#include <cmath>

#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace {

BoundLaw bound(LawParameters parameters, LawTemperature first = {}, LawTemperature second = {}) {
  BoundLaw law;
  law.law.parameters = std::move(parameters);
  law.first = first;
  law.second = second;
  return law;
}

LawTemperature part(int index) { return {index, -1, 310.0}; }
LawTemperature environment(int index) { return {-1, index}; }

void add_source(Network& network, const std::string& name, const BoundLaw& law, Eigen::Index node) {
  network.boundaries.sources.push_back({name, 1.0, {}, law});
  const Eigen::Index n = network.capacity_J_per_K.rows();
  network.source_distribution.conservativeResize(n, network.source_distribution.cols() + 1);
  network.source_distribution.rightCols(1) = Eigen::VectorXd::Unit(n, node);
}

void add_conductance(Network& network, const std::string& name, const BoundLaw& law, Eigen::Index a, Eigen::Index b,
                     int environment) {
  Conductance conductance;
  conductance.name = name;
  conductance.kind = environment < 0 ? ConductanceKind::gap_film : ConductanceKind::environment_film;
  conductance.area_m2 = 0.02;
  conductance.environment = environment;
  conductance.physics = law;
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(network.capacity_J_per_K.rows(), 2);
  for (Eigen::Index k = 0; k < 2; ++k) {
    factor(a + k, k) = 0.1;
    if (environment < 0) factor(b + k, k) = -0.1;
  }
  network.boundaries.conductances.push_back(conductance);
  network.factors_m.push_back(factor);
}

BearingHeatLaw bearing() {
  BearingHeatLaw law;
  law.friction.pitch_diameter_m = 0.065;
  law.friction.static_rating_N = 20000.0;
  law.friction.contact_angle_rad = 0.436;
  law.preload = {18.0, 9.525e-3, 0.436, 250.0, 0.0, 0.0275, 0.0375};
  law.oil = lubricant_through(313.15, 32e-6, 373.15, 5.4e-6);
  law.assembly_K = 300.15;
  return law;
}

ContactLaw contact() {
  ContactLaw law;
  law.surfaces.conductivity_W_per_mK = 45.9;
  law.surfaces.roughness_m = 1.13e-6;
  law.surfaces.slope = 0.141;
  law.surfaces.young_Pa = 116e9;
  law.assembly_K = 300.15;
  return law;
}

}  // namespace

Network make_network_with_laws() {
  Network network = make_network_with_circuit({}, 17);
  const Eigen::Index n = network.capacity_J_per_K.rows();
  Eigen::VectorXd pressure = Eigen::VectorXd::Zero(n), ring = Eigen::VectorXd::Zero(n);
  pressure.segment(0, 16).setConstant(3e3);
  pressure.segment(16, 16).setConstant(-2.6e3);
  network.contact_pressures.push_back({"seat", 2e6, pressure});
  ring[5] = 1.1e-7;
  ring[40] = -0.9e-7;
  network.deformations.push_back({"rings apart", ring});

  BoundLaw friction = bound(bearing(), part(0), part(1));
  friction.displacement = 1;
  friction.displacement_sign = -1.0;
  add_source(network, "front bearing", friction, 20);
  add_source(network, "windage", bound(WindageLaw{{0.04, 0.0005, 0.15}}, part(2), part(3)), 35);
  CopperLaw copper;
  copper.copper.resistance_20_ohm = 0.35;
  copper.rated_current_A = 20.0;
  add_source(network, "copper", bound(copper, part(3)), 60);
  add_source(network, "converter", bound(MotorEfficiencyLaw{0.93, 3000.0}), 50);
  add_source(network, "iron", bound(IronLaw{{}, 2.0, 3.0, 1.1, 6000.0}), 55);

  Boundaries& boundaries = network.boundaries;
  ContactLaw fitted = contact();
  fitted.fit = InterferenceFit{0.037, 0.04, 0.05, 219e9, 0.3, 1.2e-5, 209e9, 0.269, 1.17e-5, 4e-6, 1e-12};
  boundaries.conductances[0].physics = bound(fitted, part(0), part(1));
  BoundLaw pressed = bound(contact());
  pressed.pressure = 0;
  pressed.nominal_pressure_Pa = 2e6;
  boundaries.conductances[1].physics = pressed;
  add_conductance(network, "air gap", bound(AirGapLaw{{0.04, 0.0005, 1.17e-5}}, part(2), part(3)), 36, 52, -1);
  add_conductance(network, "balls", bound(BearingPathLaw{{18.0, 9.52e-3, 0.025}, 0.01}), 4, 22, -1);
  add_conductance(network, "end windings", bound(EndWindingLaw{{}, 0.04}), 44, 58, -1);
  add_conductance(network, "shaft in air",
                  bound(CylinderLaw{{RotationFormula::standard, 0.04}}, part(1), environment(1)), 24, 0, 1);
  add_conductance(network, "face in air", bound(DiscLaw{{RotationFormula::standard, 0.05}}, part(2), environment(1)),
                  40, 0, 1);
  add_conductance(network, "housing in air", bound(StillCylinderLaw{0.088}, part(3), environment(1)), 62, 0, 1);
  ChannelLaw channel;
  channel.shape.hydraulic_diameter_m = 0.008;
  channel.shape.perimeter_m = 0.0251;
  channel.shape.length_m = 3.0;
  for (std::size_t s = 0; s < boundaries.circuits[0].segments.size(); ++s) {
    BoundLaw film = bound(channel, part(static_cast<int>(s)), environment(0));
    film.circuit = 0;
    boundaries.conductances[static_cast<std::size_t>(boundaries.circuits[0].segments[s])].physics = film;
  }
  return network;
}

Network make_copper_node() {
  Network network = make_single_node();
  CopperLaw copper;
  copper.copper.resistance_20_ohm = 0.4;
  copper.rated_current_A = 10.0;
  network.boundaries.sources[0].physics = bound(copper, {0, -1, 300.0});
  network.boundaries.operating.load = 1.0;
  return network;
}

}  // namespace spindle_twin::rom::tests

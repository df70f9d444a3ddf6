#pragma once

#include <cmath>
#include <string>

#include "rom/network.hpp"

namespace spindle_twin::tests {

/// A spindle of five nodes, written by hand: rotor - bearing - sleeve (three key points) in coolant and ambient.
/// At the reference state (6000 rpm, everything at 27 degC) the bearing makes 60 W and the rotor 40 W.
inline rom::Network small_network() {
  constexpr double start_K = 300.15;
  rom::Network network;
  network.spindle = "small";
  network.description_hash = std::string(64, '0');
  network.nodes = {{"rotor", "rotor", 0.03, 0.1},
                   {"bearing", "bearing", 0.035, 0.05},
                   {"inner", "sleeve", 0.040, 0.372},
                   {"middle", "sleeve", 0.044, 0.360},
                   {"outer", "sleeve", 0.048, 0.348}};
  const Eigen::VectorXd capacity = (Eigen::VectorXd(5) << 1500.0, 300.0, 400.0, 500.0, 600.0).finished();
  network.capacity_J_per_K = capacity.asDiagonal();
  network.conduction_W_per_K = Eigen::MatrixXd::Zero(5, 5);
  const auto conduct = [&](int a, int b, double conductance_W_per_K) {
    network.conduction_W_per_K(a, a) += conductance_W_per_K;
    network.conduction_W_per_K(b, b) += conductance_W_per_K;
    network.conduction_W_per_K(a, b) -= conductance_W_per_K;
    network.conduction_W_per_K(b, a) -= conductance_W_per_K;
  };
  conduct(2, 3, 90.0);
  conduct(3, 4, 80.0);

  rom::Boundaries& boundaries = network.boundaries;
  boundaries.reference_speed_rpm = 6000.0;
  boundaries.environments = {{"coolant", rom::EnvironmentKind::coolant}, {"ambient", rom::EnvironmentKind::ambient}};
  boundaries.operating = {6000.0, 1.0, Eigen::VectorXd::Constant(2, start_K)};
  boundaries.reference_temperature_K = start_K;
  const auto add = [&](const char* name, rom::ConductanceKind kind, double conductance, double area_m2, int a, int b,
                       int environment) {
    rom::Conductance entry;
    entry.name = name;
    entry.kind = kind;
    entry.nominal_W_per_m2K = conductance;
    entry.area_m2 = area_m2;
    entry.environment = environment;
    boundaries.conductances.push_back(entry);
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(5, 1);
    factor(a, 0) = std::sqrt(area_m2);
    if (b >= 0) factor(b, 0) = -std::sqrt(area_m2);
    network.factors_m.push_back(factor);
  };
  add("rotor_bearing", rom::ConductanceKind::contact, 1500.0, 0.005, 0, 1, -1);
  add("bearing_sleeve", rom::ConductanceKind::contact, 3500.0, 0.008, 1, 2, -1);
  add("coolant", rom::ConductanceKind::environment_film, 500.0, 0.05, 4, -1, 0);
  add("air", rom::ConductanceKind::air_film, 8.0, 0.1, 4, -1, 1);
  boundaries.conductances[1].part_a = 1;
  boundaries.conductances[1].part_b = 2;
  boundaries.conductances[1].fit = rom::JointFit{1.5e6, 2e5, 2e5};

  rom::SpeedLaw friction;
  friction.constant = 0.0;
  friction.speed_terms = {{0.5, 1.0}, {0.5, 5.0 / 3.0}};
  rom::SpeedLaw motor;
  motor.constant = 0.35;
  motor.load_squared = 0.65;
  motor.zero_at_standstill = true;
  boundaries.sources = {{"bearing", 60.0, friction}, {"rotor", 40.0, motor}};
  boundaries.sources[0].friction = true;
  network.source_distribution = Eigen::MatrixXd::Zero(5, 2);
  network.source_distribution(1, 0) = 1.0;
  network.source_distribution(0, 1) = 1.0;

  const auto unit = [](int node) { return Eigen::VectorXd(Eigen::VectorXd::Unit(5, node)); };
  network.key_points = {{"sleeve_inner", "sleeve", 0.040, 0.372, unit(2)},
                        {"sleeve_middle", "sleeve", 0.044, 0.360, unit(3)},
                        {"sleeve_outer", "sleeve", 0.048, 0.348, unit(4)}};
  Eigen::MatrixXd sleeve = Eigen::MatrixXd::Zero(3, 5);
  sleeve.rightCols(3).setIdentity();
  network.parts = {{"rotor", unit(0), unit(0).transpose()},
                   {"bearing", unit(1), unit(1).transpose()},
                   {"sleeve", (unit(2) + unit(3) + unit(4)) / 3.0, sleeve}};
  network.deformations = {{"nose", (Eigen::VectorXd(5) << 4e-7, 2e-7, 3e-7, 4e-7, 5e-7).finished()},
                          {"rear", (Eigen::VectorXd(5) << -1e-7, 0.0, 0.0, 0.0, -2e-7).finished()}};
  network.certificate.seed = 1;
  network.certificate.cases = 20;
  network.certificate.worst = {0.02, 0.03, 0.05};
  network.certificate.median = {0.01, 0.015, 0.02};
  network.certificate.deformations_m = {{3e-8, 1.5e-8, 1e-8}, {2e-8, 1e-8, 0.0}};
  return network;
}

/// The same as who wrote it by hand would have it: nobody has measured what it is wrong by.
inline rom::Network small_network_by_hand() {
  rom::Network network = small_network();
  network.hand_written = true;
  network.certificate = {};
  return network;
}

/// The small network whose films and contacts let so much more heat through.
inline rom::Network with_conductances(double factor) {
  rom::Network network = small_network();
  for (rom::Conductance& conductance : network.boundaries.conductances) conductance.nominal_W_per_m2K *= factor;
  return network;
}

}  // namespace spindle_twin::tests

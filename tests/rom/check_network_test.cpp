#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/rom/synthetic_network.hpp"

/// A network is taken up to the ends of what each of its numbers may be, and refused beyond with the number's name.
namespace spindle_twin::rom::tests {
namespace check_network_test {

/// Something of everything: circuit, laws of speed, a fit, joint pressures, an outline, a certificate.
Network network_of_everything() {
  Network network = make_network_with_circuit({3, 2, 2, true}, 5);
  const Eigen::Index n = network.capacity_J_per_K.rows();
  network.boundaries.conductances[0].fit.emplace();
  network.boundaries.sources[0].law = {0.1, {{0.9, 1.5}}, 0.2, false};
  network.contact_pressures = {{"fit", 2e6, Eigen::VectorXd::Zero(n)}};
  network.outlines = {{network.parts[0].name, Eigen::MatrixXd::Random(2, 3)}};
  Certificate& certificate = network.certificate;
  certificate = {};
  certificate.cases = 10;
  certificate.worst = {0.1, 0.2, 0.3};
  certificate.box = {0.1, 10.0, 0.2, 5.0, 24000.0};
  certificate.key_points_K.assign(network.key_points.size(), {0.03, 0.01, 0.002});
  certificate.contact_pressures_Pa = {{1200.0, 300.0, 80.0}};
  return network;
}

std::string refusal(const Network& network) {
  try {
    check_network(network, "x.rom");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

using Pick = std::function<double&(Network&)>;
struct Number {
  const char* field;  ///< what the refusal names
  Pick of;
};

const std::vector<Number> from_zero = {
    {"conductance", [](Network& n) -> double& { return n.boundaries.conductances[1].nominal_W_per_m2K; }},
    {"area_m2", [](Network& n) -> double& { return n.boundaries.conductances[0].area_m2; }},
    {"exponent", [](Network& n) -> double& { return n.boundaries.sources[0].law.speed_terms[0].exponent; }},
    {"nominal_W", [](Network& n) -> double& { return n.boundaries.sources[1].nominal_W; }},
    {"certificate key_points_K", [](Network& n) -> double& { return n.certificate.worst.key_points_K; }},
    {"certificate nose_um", [](Network& n) -> double& { return n.certificate.median.nose_um; }},
    {"certificate part_max_K", [](Network& n) -> double& { return n.certificate.worst.part_max_K; }},
    {"certificate box", [](Network& n) -> double& { return n.certificate.box.contact_low; }},
    {"certificate box", [](Network& n) -> double& { return n.certificate.box.film_low; }},
    {"certificate box", [](Network& n) -> double& { return n.certificate.box.speed_high_rpm; }},
    {"certificate mesh_size_m", [](Network& n) -> double& { return n.certificate.mesh_size_m; }},
    {"certificate of the key points", [](Network& n) -> double& { return n.certificate.key_points_K[0].median; }},
    {"certificate of the key points", [](Network& n) -> double& { return n.certificate.key_points_K[1].mesh; }},
    {"certificate of the contact", [](Network& n) -> double& { return n.certificate.contact_pressures_Pa[0].mesh; }},
};

const std::vector<Number> above_zero = {
    {"reference_temperature_K", [](Network& n) -> double& { return n.boundaries.reference_temperature_K; }},
    {"operating_K", [](Network& n) -> double& { return n.boundaries.operating.environment_K[1]; }},
    {"heat capacity", [](Network& n) -> double& { return n.boundaries.circuits[0].heat_capacity_J_per_kgK; }},
};

const std::vector<Number> any_finite = {
    {"operating_speed_rpm", [](Network& n) -> double& { return n.boundaries.operating.speed_rpm; }},
    {"operating_load", [](Network& n) -> double& { return n.boundaries.operating.load; }},
    {"operating flow", [](Network& n) -> double& { return n.boundaries.operating.flow_kg_per_s[0]; }},
    {"law constant", [](Network& n) -> double& { return n.boundaries.sources[0].law.constant; }},
    {"law load_squared", [](Network& n) -> double& { return n.boundaries.sources[0].law.load_squared; }},
    {"law coefficient", [](Network& n) -> double& { return n.boundaries.sources[0].law.speed_terms[0].coefficient; }},
    {"assembly_pressure_Pa",
     [](Network& n) -> double& { return n.boundaries.conductances[0].fit->assembly_pressure_Pa; }},
    {"inner_rise",
     [](Network& n) -> double& { return n.boundaries.conductances[0].fit->pressure_per_inner_rise_Pa_per_K; }},
    {"outer_rise",
     [](Network& n) -> double& { return n.boundaries.conductances[0].fit->pressure_per_outer_rise_Pa_per_K; }},
    {"node", [](Network& n) -> double& { return n.nodes[2].r_m; }},
    {"node", [](Network& n) -> double& { return n.nodes[3].z_m; }},
    {"key point", [](Network& n) -> double& { return n.key_points[1].r_m; }},
    {"key point", [](Network& n) -> double& { return n.key_points[0].z_m; }},
    {"deformation", [](Network& n) -> double& { return n.deformations[0].row_m_per_K[1]; }},
    {"contact pressure", [](Network& n) -> double& { return n.contact_pressures[0].assembly_pressure_Pa; }},
    {"contact pressure", [](Network& n) -> double& { return n.contact_pressures[0].row_Pa_per_K[1]; }},
    {"outline", [](Network& n) -> double& { return n.outlines[0].points_m(1, 2); }},
};

void expect(const Number& number, double value, bool taken) {
  Network network = network_of_everything();
  number.of(network) = value;
  const std::string said = refusal(network);
  if (taken) {
    EXPECT_EQ(said, "") << number.field << " = " << value;
  } else {
    EXPECT_NE(said.find(number.field), std::string::npos) << number.field << " = " << value << ": " << said;
  }
}

TEST(CheckNetwork, takes_each_number_up_to_its_end_and_refuses_it_beyond_by_name) {
  ASSERT_EQ(refusal(network_of_everything()), "");
  constexpr double least = 1e-12;
  for (const Number& number : from_zero) {
    expect(number, 0.0, true);
    expect(number, -least, false);
  }
  for (const Number& number : above_zero) {
    expect(number, least, true);
    expect(number, 0.0, false);
  }
  for (const Number& number : any_finite) expect(number, -1.0, true);
  for (const auto* numbers : {&from_zero, &above_zero, &any_finite}) {
    for (const Number& number : *numbers) {
      expect(number, std::numeric_limits<double>::quiet_NaN(), false);
      expect(number, std::numeric_limits<double>::infinity(), false);
    }
  }
}

struct Index {
  const char* field;
  int least;
  std::size_t count;
  std::function<int&(Network&)> of;
};

TEST(CheckNetwork, takes_indices_of_what_there_is_only) {
  const Network whole = network_of_everything(), laws = make_network_with_laws();
  const auto check = [](const Network& of, const Index& index) {
    for (const int at :
         {index.least - 1, index.least, static_cast<int>(index.count) - 1, static_cast<int>(index.count)}) {
      Network network = of;
      index.of(network) = at;
      const bool exists = at >= index.least && at < static_cast<int>(index.count);
      EXPECT_EQ(refusal(network).find(index.field) == std::string::npos, exists) << index.field << " " << at;
    }
  };
  const std::size_t environments = whole.boundaries.environments.size();
  check(whole, {"environment: names one", -1, environments,
                [](Network& n) -> int& { return n.boundaries.conductances[0].environment; }});
  check(whole, {"part: names one", -1, whole.parts.size(),
                [](Network& n) -> int& { return n.boundaries.conductances[0].part_a; }});
  check(whole, {"part: names one", -1, whole.parts.size(),
                [](Network& n) -> int& { return n.boundaries.conductances[0].part_b; }});
  check(whole, {"environment: names one", 0, environments,
                [](Network& n) -> int& { return n.boundaries.circuits[0].environment; }});
  check(whole, {"names a conductance that does not exist", 0, whole.boundaries.conductances.size(),
                [](Network& n) -> int& { return n.boundaries.circuits[0].segments[0]; }});
  check(laws, {"law part: names one", -1, laws.parts.size(),
               [](Network& n) -> int& { return n.boundaries.sources[2].physics->first.part; }});
  check(laws, {"law pressure: names one", -1, laws.contact_pressures.size(),
               [](Network& n) -> int& { return n.boundaries.sources[2].physics->pressure; }});
  check(laws, {"law displacement: names one", -1, laws.deformations.size(),
               [](Network& n) -> int& { return n.boundaries.sources[2].physics->displacement; }});
}

TEST(CheckNetwork, edges_and_errors_may_be_alike_but_not_the_wrong_way_round) {
  const auto said = [](const std::function<void(Network&)>& change) {
    Network network = network_of_everything();
    change(network);
    return refusal(network);
  };
  EXPECT_EQ(said([](Network& n) { n.certificate.box.contact_low = n.certificate.box.contact_high; }), "");
  EXPECT_EQ(said([](Network& n) { n.certificate.box.film_low = n.certificate.box.film_high; }), "");
  EXPECT_NE(said([](Network& n) { n.certificate.box.contact_low = 10.1; }), "");
  EXPECT_NE(said([](Network& n) { n.certificate.box.film_low = 5.1; }), "");
  EXPECT_EQ(said([](Network& n) { n.certificate.key_points_K[0].median = n.certificate.key_points_K[0].worst; }), "");
  EXPECT_NE(said([](Network& n) { n.certificate.key_points_K[0].median = 0.031; }), "");
  EXPECT_NE(said([](Network& n) { n.certificate.key_points_K.pop_back(); }), "");
  EXPECT_EQ(said([](Network& n) { n.certificate.key_points_K.clear(); }), "");
  EXPECT_NE(said([](Network& n) { n.hand_written = true; }), "") << "a certificate is of an FE model";
  EXPECT_EQ(said([](Network& n) {
              n.hand_written = true;
              n.certificate = {};
            }),
            "");
  EXPECT_NE(said([](Network& n) { n.outlines[0].points_m.resize(2, 2); }), "") << "a ring has three points";
}

TEST(CheckNetwork, a_circuit_has_segments_with_an_area_each_once_and_at_its_own_surroundings) {
  const auto said = [](const std::function<void(CoolantCircuit&, Network&)>& change) {
    Network network = network_of_everything();
    change(network.boundaries.circuits[0], network);
    return refusal(network);
  };
  EXPECT_NE(said([](CoolantCircuit& circuit, Network&) { circuit.segments.clear(); }).find("has no segment"),
            std::string::npos);
  EXPECT_NE(said([](CoolantCircuit& circuit, Network&) {
              circuit.segments.push_back(circuit.segments[0]);
            }).find("is in a circuit twice"),
            std::string::npos);
  EXPECT_NE(said([](CoolantCircuit& circuit, Network& n) {
              n.boundaries.conductances[static_cast<std::size_t>(circuit.segments[0])].area_m2 = 0.0;
            }).find("must be a film with an area"),
            std::string::npos);
  EXPECT_NE(said([](CoolantCircuit& circuit, Network& n) {
              n.boundaries.conductances[static_cast<std::size_t>(circuit.segments[0])].environment =
                  1 - circuit.environment;
            }).find("to the circuit's own environment"),
            std::string::npos);
}

}  // namespace check_network_test
}  // namespace spindle_twin::rom::tests

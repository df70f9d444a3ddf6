#include "host_tools/network_files/spice_netlist.hpp"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <map>
#include <sstream>

#include "rom/read/input_error.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::host_tools::tests {
namespace spice_netlist_test {

/// The elements of a netlist by name, each with the rest of its line.
std::map<std::string, std::string> elements(const std::string& netlist) {
  std::map<std::string, std::string> found;
  std::istringstream lines(netlist);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t space = line.find(' ');
    if (space != std::string::npos && std::isupper(static_cast<unsigned char>(line[0])) != 0) {
      EXPECT_TRUE(found.emplace(line.substr(0, space), line.substr(space + 1)).second) << "twice: " << line;
    }
  }
  return found;
}

/// The value at the end of a two-terminal element between `nodes`.
double value(const std::map<std::string, std::string>& all, const std::string& name, const std::string& nodes) {
  const auto found = all.find(name);
  if (found == all.end() || found->second.rfind(nodes + " ", 0) != 0) {
    ADD_FAILURE() << name << " between " << nodes << " is missing";
    return 0.0;
  }
  return std::stod(found->second.substr(nodes.size() + 1));
}

/// Two nodes that share capacity (mutual -20 J/K), conduct 4 W/K, and lose 25 W/K from the first to ambient.
rom::Network two_nodes() {
  rom::Network network = rom::tests::make_single_node();
  network.nodes.push_back({"rim", "body", 0.01, 0.0});
  network.capacity_J_per_K = (Eigen::Matrix2d() << 1000.0, -20.0, -20.0, 500.0).finished();
  network.conduction_W_per_K = (Eigen::Matrix2d() << 4.0, -4.0, -4.0, 4.0).finished();
  network.source_distribution = Eigen::Vector2d(0.75, 0.25);
  network.factors_m = {Eigen::Vector2d(std::sqrt(0.5), 0.0)};
  network.key_points[0].row = Eigen::Vector2d(0.5, 0.5);
  network.parts[0].mean_row = Eigen::Vector2d(0.5, 0.5);
  network.parts[0].candidate_rows = Eigen::MatrixXd::Identity(2, 2);
  network.deformations[0].row_m_per_K = Eigen::Vector2d(2e-6, 1e-6);
  return network;
}

std::string netlist_of(const rom::Network& network) {
  const rom::Schedule schedule = rom::constant_schedule(network.boundaries, 3600.0);
  return spice_netlist(network, course_of(network.boundaries, schedule), {"net.data", "day.csv", {}});
}

TEST(SpiceNetlist, elements_are_the_entries_of_the_matrices) {
  const rom::Network network = two_nodes();
  const std::string text = netlist_of(network);
  const auto all = elements(text);
  EXPECT_DOUBLE_EQ(value(all, "Cn1", "n1 0"), 980.0);  // row sums: C = diag(row sums) plus mutual capacities
  EXPECT_DOUBLE_EQ(value(all, "Cn2", "n2 0"), 480.0);
  EXPECT_DOUBLE_EQ(value(all, "Cn1_n2", "n1 n2"), 20.0);
  EXPECT_DOUBLE_EQ(value(all, "Rn1_n2", "n1 n2"), 1.0 / 4.0);
  EXPECT_DOUBLE_EQ(value(all, "Renv1_n1", "n1 env1"), 1.0 / 25.0);
  EXPECT_EQ(all.count("Renv1_n2"), 0u);
  EXPECT_EQ(all.at("Venv1"), "env1 0 DC 0");
  EXPECT_EQ(all.at("Vq1"), "q1 0 DC 100");
  EXPECT_DOUBLE_EQ(value(all, "Gq1_n1", "0 n1 q1 0"), 0.75);
  EXPECT_DOUBLE_EQ(value(all, "Gq1_n2", "0 n2 q1 0"), 0.25);
  EXPECT_DOUBLE_EQ(value(all, "Gdeformation_nose_n1", "0 deformation_nose n1 0"), 2.0);  // um/K
  EXPECT_DOUBLE_EQ(value(all, "Gdeformation_nose_n2", "0 deformation_nose n2 0"), 1.0);
  EXPECT_NE(text.find("wrdata net.data v(key_body) v(mean_body) v(deformation_nose)"), std::string::npos) << text;
  EXPECT_EQ(text.substr(text.size() - 5), ".end\n");
}

TEST(SpiceNetlist, a_film_that_follows_the_speed_is_its_matrix_times_its_course) {
  rom::Network network = two_nodes();
  network.boundaries.reference_speed_rpm = 6000.0;
  network.boundaries.conductances[0].law = {0.0, {{1.0, 1.0}}};
  rom::Schedule schedule = rom::constant_schedule(network.boundaries, 3600.0);
  schedule.rows.front().state.speed_rpm = 6000.0;
  schedule.rows.insert(schedule.rows.begin() + 1, schedule.rows.front());
  schedule.rows[1].time_s = 1800.0;
  schedule.rows[1].state.speed_rpm = 12000.0;
  const ScheduleCourse course = course_of(network.boundaries, schedule);
  const std::string text = spice_netlist(network, course, {"net.data", "day.csv", {}});
  const auto all = elements(text);
  EXPECT_EQ(all.count("Renv1_n1"), 0u);
  EXPECT_NE(text.find("Va1 a1 0 PWL(0 50\n+ 1800 50 1800.001 100\n+ )"), std::string::npos) << text;  // W/m2K
  EXPECT_DOUBLE_EQ(value(all, "Gy1_1_n1", "0 y1_1 n1 0"), 0.5);                                       // m2
  EXPECT_DOUBLE_EQ(value(all, "Gy1_1_env1", "0 y1_1 env1 0"), -0.5);
  EXPECT_EQ(all.at("By1_1"), "n1 0 I=V(a1)*V(y1_1)");
  EXPECT_EQ(all.count("By1_2"), 0u);
}

TEST(SpiceNetlist, liquid_goes_from_segment_to_segment) {
  const rom::Network network = rom::tests::make_network_with_circuit({}, 9);
  const auto all = elements(netlist_of(network));
  const std::vector<int>& segments = network.boundaries.circuits[0].segments;
  std::string liquid = "env1";
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const std::string k = std::to_string(segments[s] + 1);
    std::string next = "outlet_helix";
    if (s + 1 < segments.size()) next = std::string("t").append(std::to_string(segments[s + 1] + 1));
    ASSERT_EQ(all.count("B" + next), 1u);
    // What comes from upstream warms the wall by the film's W/m2K; of the first segment that is nothing.
    EXPECT_EQ(all.count("Bx" + k), s > 0 ? 1u : 0u);
    if (s > 0) {
      EXPECT_EQ(all.at("Bx" + k), "0 x" + k + " I=V(g" + k + ")*(V(" + liquid + ")-V(env1))");
    }
    EXPECT_EQ(all.at("B" + next), next + " 0 V=V(" + liquid + ")+V(e" + k + ")*(V(u" + k + ")-V(" + liquid + "))");
    liquid = next;
  }
}

TEST(SpiceNetlist, flow_that_turns_along_the_schedule_is_refused) {
  const rom::Network network = rom::tests::make_network_with_circuit({}, 9);
  rom::Schedule schedule = rom::constant_schedule(network.boundaries, 3600.0);
  schedule.rows.insert(schedule.rows.begin() + 1, schedule.rows.front());
  schedule.rows[1].time_s = 1800.0;
  schedule.rows[1].state.flow_kg_per_s[0] = -0.01;
  try {
    spice_netlist(network, course_of(network.boundaries, schedule), {"net.data", "day.csv", {}});
    FAIL() << "a netlist for a flow that turns";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("helix_kg_per_s"), std::string::npos) << error.what();
  }
}

}  // namespace spice_netlist_test
}  // namespace spindle_twin::host_tools::tests

#include "host_tools/network_files/spice_netlist.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>
#include <vector>

#include "host_tools/network_files/modal_form.hpp"
#include "host_tools/network_files/schedule_course.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Index = Eigen::Index;

constexpr double step_s = 1e-3;                       // what a jump of the schedule takes
constexpr double smallest_column_share = 1e-10;       // of the largest, of a term that follows the schedule
constexpr double smallest_modal_column_share = 1e-4;  // the same in modes: most of the columns carry next to nothing
constexpr double smallest_weight_share = 1e-9;        // of the largest in its row or column
constexpr double fastest_rate_per_s = 20.0;           // a mode above it is in balance with its inputs at every instant

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

template <class... Texts>
std::string joined(const Texts&... texts) {
  std::string text;
  (text.append(texts), ...);
  return text;
}

std::string node(Index i) { return joined("n", std::to_string(i + 1)); }

class Netlist {
 public:
  Netlist(const rom::Network& network, const rom::Schedule& schedule, SpiceStates states)
      : network_(network), course_(course_of(network.boundaries, schedule)) {
    uniform_.setOnes(network.capacity_J_per_K.rows());
    contained_W_per_m2K_.setZero(static_cast<Index>(network.factors_m.size()));
    if (states == SpiceStates::modes) take_modes();
  }

  std::string write(const std::string& data_file, const std::string& file);

 private:
  template <class... Texts>
  void add(const Texts&... line) {
    (text_.append(line), ...);
    text_ += '\n';
  }
  /// A voltage that takes these values at the rows; constant, stepping or running from row to row.
  void source(const std::string& name, const std::vector<double>& at_rows, bool linear);
  /// A node whose voltage is row . V(n1..nN).
  void weighted(const std::string& name, const Eigen::VectorXd& row);
  void take_modes();
  bool is_modal() const { return rates_per_s_.size() > 0; }
  /// Follows its inputs at once, without a capacity.
  bool is_instant(Index state) const { return is_modal() && rates_per_s_[state] > fastest_rate_per_s; }
  void pair(char kind, Index i, Index j, double value);
  bool follows_schedule(std::size_t conductance) const;
  void capacities();
  void inputs();
  void held_conductances();
  void modes_in_themselves();
  void driven_conductance(std::size_t conductance, const std::string& environment_node);
  void circuits(const std::string& file);
  void outputs();
  std::string output_node(const char* kind, const std::string& name);

  template <class Get>
  std::vector<double> along(Get get) const {
    std::vector<double> at_rows;
    for (const rom::BoundaryValues& values : course_.values) at_rows.push_back(get(values));
    return at_rows;
  }

  rom::Network network_;
  ScheduleCourse course_;
  Eigen::VectorXd rates_per_s_;          // of modes; empty where states are nodes
  Eigen::VectorXd uniform_;              // the states when everything is 1 K warmer
  Eigen::VectorXd contained_W_per_m2K_;  // of every conductance, what the conduction matrix has of it
  std::string text_;
  std::vector<std::string> output_nodes_;
  std::set<std::string> used_names_;
};

void Netlist::source(const std::string& name, const std::vector<double>& at_rows, bool linear) {
  std::string line = joined("V", name, " ", name, " 0 ");
  const bool constant = std::all_of(at_rows.begin(), at_rows.end(), [&](double v) { return v == at_rows[0]; });
  if (constant) {
    add(line, "DC ", number(at_rows[0]));
    return;
  }
  add(line, "PWL(0 ", number(at_rows[0]));
  for (std::size_t row = 1; row < at_rows.size(); ++row) {
    const double time_s = course_.time_s[row];
    if (linear) {
      add("+ ", number(time_s), " ", number(at_rows[row]));
    } else if (at_rows[row] != at_rows[row - 1]) {
      add("+ ", number(time_s), " ", number(at_rows[row - 1]), " ", number(time_s + step_s), " ", number(at_rows[row]));
    }
  }
  add("+ )");
}

void Netlist::weighted(const std::string& name, const Eigen::VectorXd& row) {
  add("R", name, " ", name, " 0 1");
  const double smallest = smallest_weight_share * row.lpNorm<Eigen::Infinity>();
  for (Index i = 0; i < row.size(); ++i) {
    if (std::abs(row[i]) > smallest) add("G", name, "_", node(i), " 0 ", name, " ", node(i), " 0 ", number(row[i]));
  }
}

void Netlist::pair(char kind, Index i, Index j, double value) {
  if (value == 0.0) return;
  std::string line(1, kind);
  line += joined(node(i), "_", node(j), " ", node(i), " ", node(j), " ");
  add(line, number(kind == 'R' ? 1.0 / value : value));
}

void Netlist::capacities() {
  add("\n* Capacities, J/K: to the reference, and between nodes");
  const Eigen::MatrixXd& capacity = network_.capacity_J_per_K;
  for (Index i = 0; i < capacity.rows(); ++i) {
    if (is_instant(i)) continue;
    add("C", node(i), " ", node(i), " 0 ", number(capacity.row(i).sum()));
    for (Index j = i + 1; j < capacity.cols(); ++j) pair('C', i, j, -capacity(i, j));
  }
}

void Netlist::inputs() {
  const rom::Boundaries& boundaries = network_.boundaries;
  add("\n* Environments, rise over the reference temperature in K");
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    add("* env", std::to_string(e + 1), ": ", boundaries.environments[e].name);
    source(joined("env", std::to_string(e + 1)), along([&](const rom::BoundaryValues& values) {
             return values.environment_K[static_cast<Index>(e)] - boundaries.reference_temperature_K;
           }),
           true);
  }
  add("\n* Heats in W as voltages, and the currents they drive into the nodes");
  for (std::size_t s = 0; s < boundaries.sources.size(); ++s) {
    const std::string name = joined("q", std::to_string(s + 1));
    add("* ", name, ": ", boundaries.sources[s].name);
    source(name, along([&](const rom::BoundaryValues& values) { return values.heat_W[static_cast<Index>(s)]; }), false);
    for (Index i = 0; i < network_.source_distribution.rows(); ++i) {
      const double share = network_.source_distribution(i, static_cast<Index>(s));
      if (share != 0.0) add("G", name, "_", node(i), " 0 ", node(i), " ", name, " 0 ", number(share));
    }
  }
}

bool Netlist::follows_schedule(std::size_t conductance) const {
  for (const rom::CoolantCircuit& circuit : network_.boundaries.circuits) {
    const auto& segments = circuit.segments;
    if (std::find(segments.begin(), segments.end(), static_cast<int>(conductance)) != segments.end()) return true;
  }
  const auto j = static_cast<Index>(conductance);
  return std::any_of(course_.values.begin(), course_.values.end(), [&](const rom::BoundaryValues& values) {
    return values.conductance_W_per_m2K[j] != course_.values.front().conductance_W_per_m2K[j];
  });
}

/// States in which only the conductances that follow the schedule couple, by as much as they differ from their means.
/// Of a circuit's segments the matrix has nothing: their liquid's temperature is not an environment's.
void Netlist::take_modes() {
  contained_W_per_m2K_ = course_.mean_conductances();
  for (const rom::CoolantCircuit& circuit : network_.boundaries.circuits) {
    for (const int segment : circuit.segments) contained_W_per_m2K_[segment] = 0.0;
  }
  ModalForm form = modal_form(network_, contained_W_per_m2K_);
  network_ = std::move(form.network);
  rates_per_s_ = std::move(form.rates_per_s);
  uniform_ = std::move(form.uniform);
}

void Netlist::modes_in_themselves() {
  add("\n* What every mode loses by itself, and what environments give through the mean of their films");
  for (Index i = 0; i < rates_per_s_.size(); ++i) {
    if (rates_per_s_[i] > 0.0) add("R", node(i), " ", node(i), " 0 ", number(1.0 / rates_per_s_[i]));
  }
  const rom::Boundaries& boundaries = network_.boundaries;
  Eigen::MatrixXd from_environment =
      Eigen::MatrixXd::Zero(rates_per_s_.size(), static_cast<Index>(boundaries.environments.size()));
  for (std::size_t j = 0; j < network_.factors_m.size(); ++j) {
    const int environment = boundaries.conductances[j].environment;
    if (environment < 0) continue;
    const Eigen::MatrixXd& factor = network_.factors_m[j];
    from_environment.col(environment) +=
        contained_W_per_m2K_[static_cast<Index>(j)] * factor * (factor.transpose() * uniform_);
  }
  for (Index e = 0; e < from_environment.cols(); ++e) {
    const std::string environment = joined("env", std::to_string(e + 1));
    for (Index i = 0; i < rates_per_s_.size(); ++i) {
      if (from_environment(i, e) == 0.0) continue;
      add("G", environment, "_", node(i), " 0 ", node(i), " ", environment, " 0 ", number(from_environment(i, e)));
    }
  }
}

void Netlist::held_conductances() {
  const rom::Boundaries& boundaries = network_.boundaries;
  const Index nodes = network_.conduction_W_per_K.rows();
  Eigen::MatrixXd conduction = network_.conduction_W_per_K;
  Eigen::MatrixXd to_environment =
      Eigen::MatrixXd::Zero(nodes, static_cast<Index>(boundaries.environments.size()));  // W/K
  for (std::size_t j = 0; j < network_.factors_m.size(); ++j) {
    if (follows_schedule(j)) continue;
    const Eigen::MatrixXd& factor = network_.factors_m[j];
    const double held_W_per_m2K = course_.values.front().conductance_W_per_m2K[static_cast<Index>(j)];
    conduction += held_W_per_m2K * factor * factor.transpose();
    const int environment = boundaries.conductances[j].environment;
    if (environment < 0) continue;
    to_environment.col(environment) += held_W_per_m2K * factor * (factor.transpose() * uniform_);
  }
  add("\n* Conduction, contacts and films that stay constant along the schedule");
  for (Index i = 0; i < nodes; ++i) {
    for (Index j = i + 1; j < nodes; ++j) pair('R', i, j, -conduction(i, j));
  }
  for (Index e = 0; e < to_environment.cols(); ++e) {
    const std::string environment = joined("env", std::to_string(e + 1));
    for (Index i = 0; i < nodes; ++i) {
      if (to_environment(i, e) == 0.0) continue;
      add("R", environment, "_", node(i), " ", node(i), " ", environment, " ", number(1.0 / to_environment(i, e)));
    }
  }
}

void Netlist::driven_conductance(std::size_t conductance, const std::string& environment_node) {
  const auto j = static_cast<Index>(conductance);
  const std::string g = joined("g", std::to_string(conductance + 1));
  add("\n* ", g, ": ", network_.boundaries.conductances[conductance].name, ", W/m2K");
  source(g, along([&](const rom::BoundaryValues& values) {
           return values.conductance_W_per_m2K[j] - contained_W_per_m2K_[j];
         }),
         false);
  // Fewest columns that give the same F Fᵀ.
  const Eigen::JacobiSVD<Eigen::MatrixXd> modes(network_.factors_m[conductance], Eigen::ComputeThinU);
  const Eigen::VectorXd& strength = modes.singularValues();
  for (Index k = 0; k < strength.size(); ++k) {
    const double share = is_modal() ? smallest_modal_column_share : smallest_column_share;
    if (strength[k] * strength[k] < share * strength[0] * strength[0]) break;
    const Eigen::VectorXd column = strength[k] * modes.matrixU().col(k);
    const std::string mean = joined("w", std::to_string(conductance + 1), "_", std::to_string(k + 1));
    const std::string flow = joined("p", std::to_string(conductance + 1), "_", std::to_string(k + 1));
    weighted(mean, column);
    std::string difference = joined("V(", mean, ")");
    if (!environment_node.empty())
      difference += joined("-(", number(column.dot(uniform_)), ")*V(", environment_node, ")");
    add("R", flow, " ", flow, " 0 1");
    add("B", flow, " 0 ", flow, " I=V(", g, ")*(", difference, ")");
    const double smallest = smallest_weight_share * column.lpNorm<Eigen::Infinity>();
    for (Index i = 0; i < column.size(); ++i) {
      if (std::abs(column[i]) > smallest)
        add("G", flow, "_", node(i), " ", node(i), " 0 ", flow, " 0 ", number(column[i]));
    }
  }
}

void Netlist::circuits(const std::string& file) {
  const rom::Boundaries& boundaries = network_.boundaries;
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    const rom::CoolantCircuit& circuit = boundaries.circuits[c];
    const auto index = static_cast<Index>(c);
    bool forward = false, backward = false;
    for (const rom::BoundaryValues& values : course_.values) {
      forward |= values.coolant_W_per_K[index] > 0.0;
      backward |= values.coolant_W_per_K[index] < 0.0;
    }
    if (forward && backward) {
      throw rom::InputError({file, 0}, circuit.name + "_kg_per_s",
                            "changes its sign along the schedule; a netlist has its segments in one order");
    }
    std::vector<int> segments = circuit.segments;
    if (backward) std::reverse(segments.begin(), segments.end());
    std::string liquid = joined("env", std::to_string(circuit.environment + 1));
    add("\n* Coolant circuit ", circuit.name, ": t<k> is the liquid that enters segment k, u<k> its wall, e<k> the ",
        "share of the way from one to the other that it goes");
    for (std::size_t s = 0; s < segments.size(); ++s) {
      const auto conductance = static_cast<std::size_t>(segments[s]);
      driven_conductance(conductance, liquid);
      const std::string k = joined(std::to_string(conductance + 1));
      const Eigen::MatrixXd& factor = network_.factors_m[conductance];
      const Eigen::VectorXd wall = factor * (factor.transpose() * uniform_);
      const double area_m2 = wall.dot(uniform_);
      weighted(joined("u", k), wall / area_m2);
      source(joined("e", k), along([&](const rom::BoundaryValues& values) {
               const double flow_W_per_K = std::abs(values.coolant_W_per_K[index]);
               return flow_W_per_K > 0.0
                          ? values.conductance_W_per_m2K[static_cast<Index>(conductance)] * area_m2 / flow_W_per_K
                          : 1.0;
             }),
             false);
      const std::string next = s + 1 < segments.size() ? joined("t", std::to_string(segments[s + 1] + 1))
                                                       : output_node("outlet", circuit.name);
      add("B", next, " ", next, " 0 V=V(", liquid, ")+V(e", k, ")*(V(u", k, ")-V(", liquid, "))");
      liquid = next;
    }
  }
}

std::string Netlist::output_node(const char* kind, const std::string& name) {
  std::string text = std::string(kind) + "_";
  for (const char letter : name) {
    const auto byte = static_cast<unsigned char>(letter);
    text += std::isalnum(byte) != 0 ? static_cast<char>(std::tolower(byte)) : '_';
  }
  while (!used_names_.insert(text).second) text += "_";
  output_nodes_.push_back(text);
  return text;
}

void Netlist::outputs() {
  add("\n* Outputs: rises in K, deformations in um, changes of pressure in MPa");
  for (const rom::KeyPoint& point : network_.key_points) weighted(output_node("key", point.name), point.row);
  for (const rom::PartOutput& part : network_.parts) weighted(output_node("mean", part.name), part.mean_row);
  for (const rom::DeformationOutput& output : network_.deformations) {
    weighted(output_node("deformation", output.name), rom::um_per_m * output.row_m_per_K);
  }
  for (const rom::ContactPressureOutput& output : network_.contact_pressures) {
    weighted(output_node("pressure", output.name), 1e-6 * output.row_Pa_per_K);
  }
}

std::string Netlist::write(const std::string& data_file, const std::string& file) {
  const rom::Boundaries& boundaries = network_.boundaries;
  add("* Thermal network of spindle '", network_.spindle, "', ", std::to_string(network_.nodes.size()), " nodes");
  if (is_modal()) {
    add("* States are modes of the mean conductances, not nodes: voltages of outputs are what they are called");
  }
  add("* Voltage: rise over ", number(boundaries.reference_temperature_K), " K; current: W. Run: ngspice -b FILE");
  add("* Description SHA-256 ", network_.description_hash);
  if (rom::has_physics(boundaries)) add("* Physical laws are held at their nominal temperatures");
  for (std::size_t i = 0; i < network_.nodes.size(); ++i) {
    add("* ", node(static_cast<Index>(i)), ": ", network_.nodes[i].name);
  }
  inputs();
  capacities();
  is_modal() ? modes_in_themselves() : held_conductances();
  std::set<std::size_t> in_circuits;
  for (const rom::CoolantCircuit& circuit : boundaries.circuits) {
    for (const int segment : circuit.segments) in_circuits.insert(static_cast<std::size_t>(segment));
  }
  for (std::size_t j = 0; j < network_.factors_m.size(); ++j) {
    if (in_circuits.contains(j) || !follows_schedule(j)) continue;
    const int environment = boundaries.conductances[j].environment;
    driven_conductance(j, environment < 0 ? std::string() : joined("env", std::to_string(environment + 1)));
  }
  circuits(file);
  outputs();

  const double start_rise_K =
      rom::rest_temperature_K(boundaries, course_.states.front()) - boundaries.reference_temperature_K;
  add("");
  for (Index i = 0; i < network_.capacity_J_per_K.rows(); ++i) {
    if (!is_instant(i)) add(".ic v(", node(i), ")=", number(start_rise_K * uniform_[i]));
  }
  add(".options method=gear maxord=2 reltol=1e-5 vntol=1e-6 abstol=1e-6 chgtol=1e-6");
  const double longest_step_s = std::min(10.0, course_.time_s.back() / 50.0);
  add(".tran ", number(longest_step_s), " ", number(course_.time_s.back()), " 0 ", number(longest_step_s), " uic");
  add(".control\nset numdgt=12\nset wr_singlescale\nset wr_vecnames\nrun\nwrdata ", data_file);
  text_.pop_back();
  for (const std::string& name : output_nodes_) text_ += " v(" + name + ")";
  add("\nquit\n.endc\n.end");
  return std::move(text_);
}

}  // namespace

SpiceStates usual_states(const rom::Network& network) {
  constexpr std::size_t most_nodes = 60;
  return network.nodes.size() > most_nodes ? SpiceStates::modes : SpiceStates::nodes;
}

std::string spice_netlist(const rom::Network& network, const rom::Schedule& schedule, const SpiceTarget& target) {
  return Netlist(network, schedule, target.states).write(target.data_file, target.file);
}

}  // namespace spindle_twin::host_tools

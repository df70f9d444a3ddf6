#include "host_tools/network_files/spice_netlist.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>
#include <vector>

#include "host_tools/network_files/driven_terms.hpp"
#include "host_tools/network_files/schedule_course.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Index = Eigen::Index;

constexpr double step_s = 1e-3;                 // what a jump of the schedule takes
constexpr double smallest_weight_share = 1e-9;  // of the largest in its row or column

/// How much wider ngspice's tolerances are than where rows are 15 min long: what its steps take behind a jump is most
/// of its time where rows are short, and errors of a few steps in a row fade before they add up.
double wider(const ScheduleCourse& course) {
  const double mean_row_s = course.time_s.back() / static_cast<double>(course.time_s.size() - 1);
  return std::clamp(900.0 / mean_row_s, 1.0, 15.0);
}

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
  Netlist(const rom::Network& network, const ScheduleCourse& course)
      : network_(network), course_(course), driven_(driven_terms(network, course)) {}

  std::string write(const SpiceTarget& target);

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
  void pair(char kind, Index i, Index j, double value);
  void capacities();
  void inputs();
  void held_conductances();
  /// A current I = expression, of which every node gets `share`.
  void shared_current(const std::string& name, const std::string& expression, const Eigen::VectorXd& share);
  void driven_term(const DrivenTerm& term, const std::string& number);
  void circuits(const std::string& file);
  void segment(const rom::CoolantCircuit& circuit, Index index, int conductance, const std::string& liquid);
  void outputs();
  void run(const std::string& data_file);
  std::string output_node(const char* kind, const std::string& name);

  template <class Get>
  std::vector<double> along(Get get) const {
    std::vector<double> at_rows;
    for (const rom::BoundaryValues& values : course_.values) at_rows.push_back(get(values));
    return at_rows;
  }

  const rom::Network& network_;
  const ScheduleCourse& course_;
  DrivenTerms driven_;
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

void Netlist::held_conductances() {
  const rom::Boundaries& boundaries = network_.boundaries;
  const Index nodes = network_.conduction_W_per_K.rows();
  Eigen::MatrixXd conduction = network_.conduction_W_per_K;
  Eigen::MatrixXd to_environment =
      Eigen::MatrixXd::Zero(nodes, static_cast<Index>(boundaries.environments.size()));  // W/K
  for (std::size_t j = 0; j < network_.factors_m.size(); ++j) {
    const double held_W_per_m2K = driven_.held_W_per_m2K[static_cast<Index>(j)];
    if (held_W_per_m2K == 0.0) continue;
    const Eigen::MatrixXd& factor = network_.factors_m[j];
    conduction += held_W_per_m2K * factor * factor.transpose();
    const int environment = boundaries.conductances[j].environment;
    if (environment < 0) continue;
    to_environment.col(environment) += held_W_per_m2K * factor * factor.colwise().sum().transpose();
  }
  add("\n* Conduction, and what of contacts and films stays constant along the schedule");
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

void Netlist::shared_current(const std::string& name, const std::string& expression, const Eigen::VectorXd& share) {
  add("R", name, " ", name, " 0 1");
  add("B", name, " 0 ", name, " I=", expression);
  const double smallest = smallest_weight_share * share.lpNorm<Eigen::Infinity>();
  for (Index i = 0; i < share.size(); ++i) {
    if (std::abs(share[i]) > smallest) add("G", name, "_", node(i), " 0 ", node(i), " ", name, " 0 ", number(share[i]));
  }
}

void Netlist::driven_term(const DrivenTerm& term, const std::string& number_of_term) {
  const std::string a = joined("a", number_of_term);
  add("\n* ", a, ": ", term.what, "; times y", number_of_term, "_<i> the heat that leaves node i");
  source(a, term.course, false);
  for (Index i = 0; i < term.matrix.rows(); ++i) {
    if (term.matrix.row(i).isZero(0.0)) continue;
    const std::string flow = joined("y", number_of_term, "_", std::to_string(i + 1));
    weighted(flow, term.matrix.row(i));
    for (Index e = 0; e < term.from_environment.cols(); ++e) {
      const double share = -term.from_environment(i, e);
      const std::string environment = joined("env", std::to_string(e + 1));
      if (share != 0.0) add("G", flow, "_", environment, " 0 ", flow, " ", environment, " 0 ", number(share));
    }
    add("B", flow, " ", node(i), " 0 I=V(", a, ")*V(", flow, ")");
  }
}

/// The liquid t<k> that enters a segment warms or cools its wall by what it differs from the inlet.
void Netlist::segment(const rom::CoolantCircuit& circuit, Index index, int conductance, const std::string& liquid) {
  const std::string k = std::to_string(conductance + 1);
  const std::string inlet = joined("env", std::to_string(circuit.environment + 1));
  const Eigen::MatrixXd& factor = network_.factors_m[static_cast<std::size_t>(conductance)];
  const Eigen::VectorXd wall_m2 = factor * factor.colwise().sum().transpose();
  const double area_m2 = wall_m2.sum();
  weighted(joined("u", k), wall_m2 / area_m2);
  source(joined("e", k), along([&](const rom::BoundaryValues& values) {
           const double flow_W_per_K = std::abs(values.coolant_W_per_K[index]);
           return flow_W_per_K > 0.0 ? values.conductance_W_per_m2K[conductance] * area_m2 / flow_W_per_K : 1.0;
         }),
         false);
  if (liquid == inlet) return;
  source(joined("g", k),
         along([&](const rom::BoundaryValues& values) { return values.conductance_W_per_m2K[conductance]; }), false);
  shared_current(joined("x", k), joined("V(g", k, ")*(V(", liquid, ")-V(", inlet, "))"), wall_m2);
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
        "share of the way from one to the other that it goes, g<k> W/m2K, x<k> W/m2 besides those of the inlet");
    for (std::size_t s = 0; s < segments.size(); ++s) {
      segment(circuit, index, segments[s], liquid);
      const std::string k = std::to_string(segments[s] + 1);
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

void Netlist::run(const std::string& data_file) {
  const double start_rise_K = rom::rest_temperature_K(network_.boundaries, course_.states.front()) -
                              network_.boundaries.reference_temperature_K;
  const Eigen::MatrixXd& capacity = network_.capacity_J_per_K;
  add("");
  for (Index i = 0; i < capacity.rows(); ++i) add(".ic v(", node(i), ")=", number(start_rise_K));
  const double mean_capacity_J_per_K = capacity.sum() / static_cast<double>(capacity.rows());
  // chgtol: the heat that a capacitor's counts as at the least when ngspice chooses a step. Without it the step follows
  // the smallest of the mutual capacitors. trtol: how many times its tolerances a step's estimated error may be.
  add(".options method=gear maxord=2 reltol=", number(1e-6 * wider(course_)),
      " vntol=1e-6 abstol=1e-6 trtol=2 chgtol=", number(0.1 * wider(course_) * mean_capacity_J_per_K));
  const double longest_step_s = std::min(10.0, course_.time_s.back() / 50.0);
  add(".tran ", number(longest_step_s), " ", number(course_.time_s.back()), " 0 ", number(longest_step_s), " uic");
  add(".control\nset numdgt=12\nset wr_singlescale\nset wr_vecnames\nrun\nwrdata ", data_file);
  text_.pop_back();
  for (const std::string& name : output_nodes_) text_ += " v(" + name + ")";
  add("\nquit\n.endc\n.end");
}

std::string Netlist::write(const SpiceTarget& target) {
  const rom::Boundaries& boundaries = network_.boundaries;
  add("* Thermal network of spindle '", network_.spindle, "', ", std::to_string(network_.nodes.size()), " nodes");
  if (!target.remark.empty()) add("* ", target.remark);
  add("* Voltage: rise over ", number(boundaries.reference_temperature_K), " K; current: W. Run: ngspice -b FILE");
  add("* Description SHA-256 ", network_.description_hash);
  if (rom::has_physics(boundaries)) add("* Physical laws are held at their nominal temperatures");
  for (std::size_t i = 0; i < network_.nodes.size(); ++i) {
    add("* ", node(static_cast<Index>(i)), ": ", network_.nodes[i].name);
  }
  inputs();
  capacities();
  held_conductances();
  for (std::size_t m = 0; m < driven_.terms.size(); ++m) driven_term(driven_.terms[m], std::to_string(m + 1));
  circuits(target.file);
  outputs();
  run(target.data_file);
  return std::move(text_);
}

}  // namespace

std::string spice_netlist(const rom::Network& network, const ScheduleCourse& course, const SpiceTarget& target) {
  return Netlist(network, course).write(target);
}

}  // namespace spindle_twin::host_tools

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>

#include "host_tools/commands/commands.hpp"
#include "host_tools/inspection/network_facts.hpp"
#include "rom/read/input_error.hpp"

// spindle-twin diff old.rom new.rom
namespace spindle_twin::host_tools {
namespace {

constexpr int files_differ = 1;
constexpr int trouble = 2;  // as diff(1) has it

struct Difference {
  Fact first;  ///< without a value of its own where only the second file has it
  std::optional<Fact> second;
  bool only_second = false;
};

using Key = std::tuple<std::string, std::string, std::string>;
Key key_of(const Fact& fact) { return {fact.section, fact.name, fact.field}; }

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool same(const Fact& a, const Fact& b) {
  if (a.value.index() != b.value.index()) return false;
  if (const double* number = std::get_if<double>(&a.value)) return same(*number, std::get<double>(b.value));
  if (const std::string* text = std::get_if<std::string>(&a.value)) return *text == std::get<std::string>(b.value);
  const auto &x = std::get<Eigen::MatrixXd>(a.value), &y = std::get<Eigen::MatrixXd>(b.value);
  return x.rows() == y.rows() && x.cols() == y.cols() && x == y;
}

bool is_matrix(const Fact& fact) { return std::holds_alternative<Eigen::MatrixXd>(fact.value); }

/// With other nodes every matrix is another one, which the nodes say already.
bool same_nodes(const Inspection& a, const Inspection& b) {
  const auto &x = a.network.nodes, &y = b.network.nodes;
  return x.size() == y.size() && std::equal(x.begin(), x.end(), y.begin(),
                                            [](const rom::Node& p, const rom::Node& q) { return p.name == q.name; });
}

std::vector<Difference> differences(const Inspection& a, const Inspection& b) {
  const std::vector<Fact> ours = network_facts(a), theirs = network_facts(b);
  const bool matrices = same_nodes(a, b);
  std::map<Key, const Fact*> of_theirs, of_ours;
  for (const Fact& fact : theirs) of_theirs[key_of(fact)] = &fact;
  for (const Fact& fact : ours) of_ours[key_of(fact)] = &fact;
  std::vector<Difference> found;
  for (const Fact& fact : ours) {
    if (is_matrix(fact) && !matrices) continue;
    const auto other = of_theirs.find(key_of(fact));
    if (other == of_theirs.end()) {
      found.push_back({fact, std::nullopt, false});
    } else if (!same(fact, *other->second)) {
      found.push_back({fact, *other->second, false});
    }
  }
  for (const Fact& fact : theirs) {
    if (is_matrix(fact) && !matrices) continue;
    if (!of_ours.contains(key_of(fact))) found.push_back({fact, std::nullopt, true});
  }
  return found;
}

/// Largest |a − b| of two matrices, of the largest |a|; NaN for other shapes.
double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols() || a.size() == 0) return std::nan("");
  const double largest = a.cwiseAbs().maxCoeff();
  return (a - b).cwiseAbs().maxCoeff() / (largest > 0.0 ? largest : 1.0);
}

std::string text_of(const Fact& fact) {
  if (const std::string* text = std::get_if<std::string>(&fact.value)) return text->empty() ? "none" : *text;
  char text[64];
  if (const double* number = std::get_if<double>(&fact.value)) {
    std::snprintf(text, sizeof text, "%.9g", *number);
  } else {
    const auto& matrix = std::get<Eigen::MatrixXd>(fact.value);
    std::snprintf(text, sizeof text, "%ld x %ld", static_cast<long>(matrix.rows()), static_cast<long>(matrix.cols()));
  }
  return text;
}

std::string change_of(const Difference& difference) {
  char text[64] = "";
  if (!difference.second || difference.first.value.index() != difference.second->value.index()) return text;
  if (const double* a = std::get_if<double>(&difference.first.value); a != nullptr && *a != 0.0) {
    std::snprintf(text, sizeof text, "%+.3g %%", 100.0 * (std::get<double>(difference.second->value) - *a) / *a);
  } else if (is_matrix(difference.first)) {
    std::snprintf(text, sizeof text, "entries by up to %.2g of the largest",
                  relative_difference(std::get<Eigen::MatrixXd>(difference.first.value),
                                      std::get<Eigen::MatrixXd>(difference.second->value)));
  }
  return text;
}

/// Things that only one file has are told once, not field by field.
void print_table(const std::vector<Difference>& found) {
  std::string told;
  for (const Difference& difference : found) {
    const Fact& fact = difference.first;
    const std::string what = fact.section + (fact.name.empty() ? "" : " ") + fact.name;
    if (!difference.second) {
      const std::string line = what + (difference.only_second ? ": only in the second" : ": only in the first");
      if (line != told) std::printf("%s\n", line.c_str());
      told = line;
      continue;
    }
    const std::string change = change_of(difference);
    std::printf("%s %s: ", what.c_str(), fact.field.c_str());
    if (is_matrix(fact)) {
      std::printf("%s\n", change.c_str());
    } else {
      std::printf("%s -> %s%s%s%s\n", text_of(fact).c_str(), text_of(*difference.second).c_str(),
                  change.empty() ? "" : "  (", change.c_str(), change.empty() ? "" : ")");
    }
  }
}

nlohmann::ordered_json json_of(const Fact& fact) {
  if (const double* number = std::get_if<double>(&fact.value)) return *number;
  return text_of(fact);
}

void print_json(const std::vector<Difference>& found) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Difference& difference : found) {
    const Fact& fact = difference.first;
    nlohmann::ordered_json entry{{"section", fact.section}, {"name", fact.name}, {"field", fact.field}};
    entry["first"] = difference.only_second ? nlohmann::ordered_json() : json_of(fact);
    entry["second"] = difference.only_second ? json_of(fact)
                      : difference.second    ? json_of(*difference.second)
                                             : nlohmann::ordered_json();
    if (difference.second && is_matrix(fact)) {
      entry["relative_difference"] = relative_difference(std::get<Eigen::MatrixXd>(fact.value),
                                                         std::get<Eigen::MatrixXd>(difference.second->value));
    }
    list.push_back(entry);
  }
  std::printf("%s\n", nlohmann::ordered_json{{"equal", found.empty()}, {"differences", list}}.dump(1).c_str());
}

struct DiffOptions {
  std::string first, second;
  bool json = false;
};

void run_diff(const DiffOptions& options) {
  std::vector<Difference> found;
  try {
    found = differences(inspect(options.first), inspect(options.second));
  } catch (const rom::InputError& error) {
    std::fprintf(stderr, "spindle-twin: %s\n", error.what());
    throw CLI::RuntimeError(trouble);
  }
  options.json ? print_json(found) : print_table(found);
  if (!found.empty()) throw CLI::RuntimeError(files_differ);
}

}  // namespace

void add_diff(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "diff", "Say what differs between two network files; exit code 0: nothing, 1: something, 2: trouble");
  const auto options = std::make_shared<DiffOptions>();
  command->add_option("first", options->first, "network file, .rom")->required();
  command->add_option("second", options->second, "network file, .rom")->required();
  command->add_flag("--json", options->json, "as JSON");
  command->callback([options] { run_diff(*options); });
}

}  // namespace spindle_twin::host_tools

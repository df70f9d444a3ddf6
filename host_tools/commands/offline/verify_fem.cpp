#include <fmt/core.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "fem_offline/verify_cases/fem_case.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/offline/progress.hpp"
#include "rom/read/input_error.hpp"

// spindle-twin verify-fem
namespace spindle_twin::host_tools {
namespace {

using fem_offline::CaseResult;
using fem_offline::CheckedFigure;

struct VerifyFemArguments {
  std::string directory = fem_offline::default_cases_directory();
  std::vector<std::string> cases;
  double mesh_factor = 1.0;
  bool json = false;
};

constexpr const char* orders_name = "orders";
constexpr const char* estimates_name = "mesh_estimates";

std::vector<CaseResult> run_cases(const VerifyFemArguments& arguments) {
  const std::vector<std::string> files = fem_offline::case_files(arguments.directory);
  std::vector<std::string> known;
  known.reserve(files.size() + 2);
  for (const std::string& file : files) known.push_back(std::filesystem::path(file).stem().string());
  known.insert(known.end(), {orders_name, estimates_name});
  std::vector<std::string> wanted = arguments.cases.empty() ? known : arguments.cases;
  for (const std::string& id : wanted) {
    if (std::find(known.begin(), known.end(), id) != known.end()) continue;
    std::string all;
    for (const std::string& name : known) all.append(all.empty() ? "" : ", ").append(name);
    throw rom::InputError({arguments.directory, 0}, "--case",
                          fmt::format("there is no case \"{}\"; there are: {}", id, all));
  }
  ProgressDisplay display;
  std::vector<CaseResult> results;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    display.show("cases", static_cast<double>(i) / static_cast<double>(wanted.size()));
    if (wanted[i] == orders_name || wanted[i] == estimates_name) {
      const auto run_all = wanted[i] == orders_name ? fem_offline::run_orders : fem_offline::run_mesh_estimates;
      for (CaseResult& result : run_all(arguments.directory)) results.push_back(std::move(result));
      continue;
    }
    const auto at = std::find(known.begin(), known.end(), wanted[i]) - known.begin();
    results.push_back(fem_offline::run_case(files[static_cast<std::size_t>(at)], arguments.mesh_factor));
  }
  display.show("cases", 1.0);
  return results;
}

void print_json(const std::vector<CaseResult>& results, bool passed) {
  nlohmann::ordered_json json;
  json["passed"] = passed;
  json["cases"] = nlohmann::ordered_json::array();
  for (const CaseResult& result : results) {
    nlohmann::ordered_json entry{{"case", result.id}, {"proves", result.proves}, {"unknowns", result.unknowns}};
    for (const CheckedFigure& figure : result.figures) {
      entry["figures"].push_back({{"figure", figure.figure},
                                  {"unit", figure.unit},
                                  {"target", figure.target},
                                  {"result", figure.result},
                                  {"error", figure.error},
                                  {"tolerance", figure.tolerance},
                                  {"passed", figure.passed},
                                  {"source", figure.source}});
    }
    json["cases"].push_back(std::move(entry));
  }
  std::printf("%s\n", json.dump(2).c_str());
}

void print_table(const std::vector<CaseResult>& results) {
  std::size_t failed = 0, count = 0;
  std::printf("%-26s %-36s %14s %14s %-8s %10s %9s\n", "case", "figure", "target", "result", "unit", "error",
              "tolerance");
  for (const CaseResult& result : results) {
    for (const CheckedFigure& figure : result.figures) {
      std::printf("%-26s %-36s %14.7g %14.7g %-8s %10.1e %9.1e  %s\n", result.id.c_str(), figure.figure.c_str(),
                  figure.target, figure.result, figure.unit.c_str(), figure.error, figure.tolerance,
                  figure.passed ? "ok" : "FAILED");
      ++count;
      if (!figure.passed) ++failed;
    }
  }
  std::printf(
      "\n%zu of %zu figures within tolerance; errors are fractions of the case's temperature span, or of the "
      "target where it is no temperature\n",
      count - failed, count);
}

bool all_passed(const std::vector<CaseResult>& results) {
  return std::all_of(results.begin(), results.end(), [](const CaseResult& result) {
    return std::all_of(result.figures.begin(), result.figures.end(),
                       [](const CheckedFigure& figure) { return figure.passed; });
  });
}

void run(const VerifyFemArguments& arguments) {
  const std::vector<CaseResult> results = run_cases(arguments);
  const bool passed = all_passed(results);
  arguments.json ? print_json(results, passed) : print_table(results);
  if (!passed) throw std::runtime_error("verify-fem: figures outside their tolerance, see FAILED");
}

}  // namespace

void add_verify_fem(CLI::App& app) {
  auto arguments = std::make_shared<VerifyFemArguments>();
  CLI::App* command = app.add_subcommand("verify-fem", "Check the FE model against cases with known answers");
  command->add_option(
      "--case", arguments->cases,
      "only these cases, by the name of their file; 'orders' for the orders of convergence, 'mesh_estimates' "
      "for what the estimate of the mesh error is worth");
  command->add_option("--cases", arguments->directory, "folder with the cases")->capture_default_str();
  command->add_option("--mesh-factor", arguments->mesh_factor, "times the element sizes of the cases")
      ->check(CLI::Range(0.05, 20.0, "0.05 to 20"))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "as JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace spindle_twin::host_tools

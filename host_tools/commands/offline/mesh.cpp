#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/choose_mesh.hpp"
#include "fem_offline/reduce/mesh_error.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/commands/offline/missed_tolerance.hpp"
#include "host_tools/commands/offline/progress.hpp"
#include "host_tools/commands/offline/read_model.hpp"
#include "host_tools/commands/plausibility.hpp"
#include "rom/units.hpp"

// spindle-twin mesh fem_offline/spindles/reference.toml --for-um 0.01
namespace spindle_twin::host_tools {
namespace {

using fem_offline::TriedMesh;

struct MeshArguments {
  std::string spindle_path;
  std::optional<double> wanted_um;
  double most_times = 2.0;
  bool json = false;
  Plausibility plausibility;
};

constexpr double mm_per_m = 1e3;
constexpr double MPa_per_Pa = 1e-6;

struct NamedError {
  std::string kind, name, unit;
  double error = 0.0;
};

/// What to add to every output of the steady state, in the outputs' order.
std::vector<NamedError> named_errors(const fem_offline::FeModel& model) {
  const fem_offline::AffineModel& affine = model.affine();
  const Eigen::VectorXd errors = fem_offline::steady_mesh_error(model);
  std::vector<NamedError> named;
  const auto add = [&](const char* kind, const std::string& name, const char* unit, double per_SI) {
    named.push_back({kind, name, unit, per_SI * errors[static_cast<Eigen::Index>(named.size())]});
  };
  for (const auto& item : affine.key_points) add("key point", item.name, "K", 1.0);
  for (const auto& item : affine.parts) add("mean", item.name, "K", 1.0);
  for (const auto& item : affine.parts) add("maximum", item.name, "K", 1.0);
  for (const auto& item : affine.deformations) add("deformation", item.name, "um", rom::um_per_m);
  for (const auto& item : affine.contact_pressures) add("contact pressure", item.name, "MPa", MPa_per_Pa);
  return named;
}

void print_errors(const MeshArguments& arguments, const fem_offline::FeModel& model) {
  const std::vector<NamedError> errors = named_errors(model);
  if (arguments.json) {
    nlohmann::ordered_json json{{"unknowns", model.affine().places.size()}, {"errors", nlohmann::json::array()}};
    for (const NamedError& item : errors) {
      json["errors"].push_back(
          {{"output", item.kind}, {"name", item.name}, {"unit", item.unit}, {"error", item.error}});
    }
    std::printf("%s\n", json.dump(2).c_str());
    return;
  }
  std::printf("%zu unknowns; mesh error of the steady state, to be added to it\n", model.affine().places.size());
  for (const NamedError& item : errors) {
    std::printf("%-18s %-32s %10.5f %s\n", item.kind.c_str(), item.name.c_str(), item.error, item.unit.c_str());
  }
}

nlohmann::ordered_json as_json(const fem_offline::Spindle& before, const fem_offline::MeshChoice& choice) {
  nlohmann::ordered_json json{{"reached", choice.reached}, {"meshes", nlohmann::json::array()}};
  for (const TriedMesh& mesh : choice.meshes) {
    json["meshes"].push_back({{"finer", mesh.finer},
                              {"unknowns", mesh.unknowns},
                              {"error_um", rom::um_per_m * mesh.error_m},
                              {"largest_step_um", rom::um_per_m * mesh.largest_step_m}});
  }
  const auto& corner_m = choice.spindle.mesh.corner_size_m;
  if (corner_m) json["corner_element_size_mm"] = mm_per_m * *corner_m;
  json["part_element_size_mm"] = nlohmann::json::object();
  for (std::size_t part = 0; part < before.parts.size(); ++part) {
    const auto& size_m = choice.spindle.parts[part].element_size_m;
    if (size_m != before.parts[part].element_size_m) {
      json["part_element_size_mm"][before.parts[part].name] = mm_per_m * *size_m;
    }
  }
  return json;
}

void print_table(const nlohmann::ordered_json& found) {
  std::printf("%-24s %9s %12s %16s\n", "finer", "unknowns", "error um", "largest step um");
  for (const auto& mesh : found["meshes"]) {
    const std::string finer = mesh["finer"];
    std::printf("%-24s %9zu %12.4f %16.4f\n", finer.empty() ? "as described" : finer.c_str(),
                mesh["unknowns"].get<std::size_t>(), mesh["error_um"].get<double>(),
                mesh["largest_step_um"].get<double>());
  }
  std::printf("\nto be written into the description:\n");
  if (found.contains("corner_element_size_mm")) {
    std::printf("[mesh]\ncorner_element_size_mm = %.3g\n", found["corner_element_size_mm"].get<double>());
  }
  for (const auto& [part, size_mm] : found["part_element_size_mm"].items()) {
    std::printf("[[part]] \"%s\"\nelement_size_mm = %.3g\n", part.c_str(), size_mm.get<double>());
  }
}

void run(MeshArguments& arguments) {
  const fem_offline::FeModel model = read_model(arguments.spindle_path, arguments.plausibility);
  if (!arguments.wanted_um) {
    print_errors(arguments, model);
    return;
  }
  ProgressDisplay display;
  const fem_offline::Progress progress = [&](const std::string& stage, double done) { display.show(stage, done); };
  const fem_offline::MeshChoice choice = fem_offline::choose_mesh(
      model.description(), *arguments.wanted_um / rom::um_per_m, arguments.most_times, progress);
  display.show("refinements", 1.0);
  const nlohmann::ordered_json found = as_json(model.description(), choice);
  if (arguments.json) {
    std::printf("%s\n", found.dump(2).c_str());
  } else {
    print_table(found);
  }
  if (choice.reached) return;
  std::fprintf(stderr, "spindle-twin: no mesh up to %g times the unknowns keeps %g um; the last one is the nearest\n",
               arguments.most_times, *arguments.wanted_um);
  throw CLI::RuntimeError(tolerance_missed);
}

}  // namespace

void add_mesh(CLI::App& app) {
  auto arguments = std::make_shared<MeshArguments>();
  CLI::App* command = app.add_subcommand("mesh", "Mesh error of a description, and the sizes that make it small");
  command->add_option("spindle", arguments->spindle_path, "spindle description, TOML")->required();
  CLI::Option* wanted =
      command
          ->add_option("--for-um", arguments->wanted_um,
                       "look for the element sizes with which all deformations err by less than this, um. Where none "
                       "are found, the nearest are printed, with exit code 3")
          ->check(finite_range(1e-4, 1e3, "1e-4 to 1000 um"));
  command
      ->add_option("--most-times", arguments->most_times,
                   "at most so many times the unknowns of the description's mesh")
      ->check(finite_range(1.0, 20.0, "1 to 20"))
      ->needs(wanted)
      ->capture_default_str();
  arguments->plausibility.add_to(*command);
  command->add_flag("--json", arguments->json, "as JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace spindle_twin::host_tools

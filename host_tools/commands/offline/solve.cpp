#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "fem_offline/look/field_file.hpp"
#include "fem_offline/look/picture.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "fem_offline/solve/follow_schedule.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/commands/offline/mesh_report.hpp"
#include "host_tools/commands/offline/read_model.hpp"
#include "host_tools/commands/offline/solved_series.hpp"
#include "host_tools/commands/plausibility.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/units.hpp"

// spindle-twin solve fem_offline/spindles/reference.toml --steady
namespace spindle_twin::host_tools {
namespace {

using fem_offline::AffineModel;
using fem_offline::FeModel;

/// How long temperatures that run linearly along a schedule are held at their mean.
constexpr double longest_held_s = 10.0;

struct SolveOptions {
  std::string spindle_path;
  bool steady = false;
  std::string schedule_path;
  std::optional<double> uniform_rise_K;
  std::optional<double> max_step_s;  ///< in place of a tolerance
  double tolerance_K = 1e-4;
  double output_period_s = 10.0;
  bool json = false;
  bool mesh = false;
  std::string vtu_directory;
  std::string png_directory;
  Plausibility plausibility;
};

void make_folder(const std::string& directory, const char* option) {
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (failure) throw rom::InputError({directory, 0}, option, "no folder can be made: " + failure.message());
}

/// "6000 rpm, load 1, ambient 27.00 °C, coolant 27.00 °C".
std::string printed(const rom::Boundaries& boundaries, const rom::OperatingState& state) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%g rpm, load %g", state.speed_rpm, state.load);
  std::string words = text.data();
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    std::snprintf(text.data(), text.size(), " %.2f °C",
                  state.environment_K[static_cast<Eigen::Index>(i)] - rom::zero_degC_K);
    words += ", " + boundaries.environments[i].name + text.data();
  }
  return words;
}

void write_fields(const FeModel& model, const SolveOptions& options, const Eigen::VectorXd& temperatures_K,
                  const fem_offline::PictureState& shown) {
  const std::string name = std::filesystem::path(options.spindle_path).stem().string();
  if (!options.vtu_directory.empty()) {
    fem_offline::write_field_file(options.vtu_directory + "/" + name + ".vtu", model, temperatures_K);
    std::fprintf(stderr, "fields in %s/%s.vtu\n", options.vtu_directory.c_str(), name.c_str());
  }
  if (!options.png_directory.empty()) {
    for (const std::string& path :
         fem_offline::write_pictures(options.png_directory, name, picture_of(model, temperatures_K, shown))) {
      std::fprintf(stderr, "picture in %s\n", path.c_str());
    }
  }
}

void print_json(const FeModel& model, const SolvedField& field, const SolvedSeries* series) {
  nlohmann::json json = as_json(model.affine(), field);
  json["mesh"] = mesh_json(model.quality());
  if (series) json["series"] = series->json();
  std::printf("%s\n", json.dump(2).c_str());
}

/// Starts at the schedule's first ambient temperature, except parts with an initial temperature of their own, and
/// reports rises above it.
void run_schedule(const FeModel& model, SolveOptions& options) {
  const AffineModel& affine = model.affine();
  if (affine.imposed_rises_K) {
    throw rom::InputError({options.spindle_path, 0}, "imposed_temperature",
                          "the temperatures are given, so nothing changes along a schedule");
  }
  const rom::Schedule schedule = rom::read_schedule(options.schedule_path, affine.boundaries);
  options.plausibility.note_schedule(options.schedule_path, schedule, affine.boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(affine.boundaries);
  rom::OperatingState state = affine.boundaries.operating;
  rom::state_at(schedule, 0.0, state);
  rom::evaluate_boundaries(affine.boundaries, state, rom::no_correction(affine.boundaries), values);
  const double start_K = rom::rest_temperature_K(affine.boundaries, state);

  fem_offline::FeStepper stepper(affine,
                                 options.max_step_s ? fem_offline::FeScheme::order_2 : fem_offline::FeScheme::order_4);
  stepper.set_temperatures(fem_offline::initial_temperatures(affine, start_K));
  const auto field = [&] { return solved_field(affine, values, stepper.temperatures_K(), start_K); };
  SolvedSeries series(options.spindle_path, affine, options.json);
  series.add(0.0, field());
  double time_s = 0.0;
  for (long next_output = 1; time_s < schedule.end_s; ++next_output) {
    const double until_s = std::min(schedule.end_s, static_cast<double>(next_output) * options.output_period_s);
    fem_offline::follow_schedule(
        affine.boundaries, schedule,
        {time_s, until_s, options.max_step_s.value_or(longest_held_s), options.max_step_s ? 0.0 : options.tolerance_K},
        stepper, values);
    time_s = until_s;
    options.plausibility.add_temperatures(options.spindle_path, affine.boundaries, stepper.temperatures_K());
    series.add(time_s, field());
  }
  options.plausibility.note_temperatures(options.spindle_path, affine.boundaries);
  if (options.json) {
    SolvedField last = field();
    last.stresses = model.probed_stresses(stepper.temperatures_K());
    print_json(model, last, &series);
  }
  std::array<char, 32> after{};
  std::snprintf(after.data(), after.size(), "after %g s: ", schedule.end_s);
  write_fields(model, options, stepper.temperatures_K(), {after.data() + printed(affine.boundaries, state), start_K});
}

/// One field that does not change: what the rises of its report count from, and how a picture calls it.
struct StillField {
  Eigen::VectorXd temperatures_K;
  double datum_K = 0.0;
  bool is_solved = false;  ///< a heat balance; otherwise the field is given and no heat flows to speak of
  std::string title;
};

/// A uniform rise (asked for on the command line), the description's imposed field, or the steady state.
StillField still_field(const AffineModel& model, const rom::BoundaryValues& values,
                       std::optional<double> uniform_rise_K) {
  const double reference_K = model.boundaries.reference_temperature_K;
  if (uniform_rise_K) {
    const auto unknowns = static_cast<Eigen::Index>(model.places.size());
    return {Eigen::VectorXd::Constant(unknowns, reference_K + *uniform_rise_K), reference_K, false,
            "uniform rise, no heat flows"};
  }
  const Eigen::VectorXd steady_K = fem_offline::solve_steady(model, values);
  if (model.imposed_rises_K) return {steady_K, reference_K, false, "imposed temperatures"};
  const rom::OperatingState& operating = model.boundaries.operating;
  return {steady_K, rom::rest_temperature_K(model.boundaries, operating), true,
          "steady state: " + printed(model.boundaries, operating)};
}

void run_field(const FeModel& model, SolveOptions& options) {
  const AffineModel& affine = model.affine();
  rom::BoundaryValues values = rom::make_boundary_values(affine.boundaries);
  rom::evaluate_boundaries(affine.boundaries, affine.boundaries.operating, rom::no_correction(affine.boundaries),
                           values);
  const StillField still = still_field(affine, values, options.uniform_rise_K);
  if (!still.is_solved) {
    values.heat_W.setZero();
    values.conductance_W_per_m2K.setZero();
  }
  SolvedField field = solved_field(affine, values, still.temperatures_K, still.datum_K);
  if (still.is_solved) {
    options.plausibility.add_temperatures(options.spindle_path, affine.boundaries, still.temperatures_K);
    options.plausibility.note_temperatures(options.spindle_path, affine.boundaries);
  }
  if (still.is_solved) field.heat = fem_offline::steady_heat_balance(affine, values, still.temperatures_K);
  field.stresses = model.probed_stresses(still.temperatures_K);
  if (options.json) {
    print_json(model, field, nullptr);
  } else {
    if (options.mesh) print_mesh_table(model.quality());
    print_table(affine, field);
  }
  write_fields(model, options, still.temperatures_K, {still.title, still.datum_K});
}

}  // namespace

void add_solve(CLI::App& app) {
  auto options = std::make_shared<SolveOptions>();
  CLI::App* command = app.add_subcommand("solve", "Solve the FE model: steady (default) or along a schedule");
  command->add_option("spindle", options->spindle_path, "spindle description, TOML")->required();
  auto* steady = command->add_flag("--steady", options->steady, "steady state at the description's operating state");
  auto* schedule =
      command->add_option("--schedule", options->schedule_path,
                          "CSV time_s,speed_rpm,load[,<environment>_degC][,<circuit>_kg_per_s]; prints a time series");
  auto* uniform = command
                      ->add_option("--uniform-rise-K", options->uniform_rise_K,
                                   "deformation of a uniform rise above the reference temperature")
                      ->check(finite_range(-1e3, 1e3, "-1000 to 1000 K"));
  const CLI::Validator duration = finite_range(1e-3, 1e6, "1e-3 to 1e6 s");
  auto* tolerance = command
                        ->add_option("--step-tolerance-K", options->tolerance_K,
                                     "what a time step along a schedule may err; steps follow it")
                        ->check(finite_range(1e-8, 1.0, "1e-8 to 1 K"))
                        ->needs(schedule)
                        ->capture_default_str();
  command->add_option("--max-step", options->max_step_s, "steps of order 2 up to this long in place of a tolerance, s")
      ->check(duration)
      ->needs(schedule)
      ->excludes(tolerance);
  command->add_option("--output-period", options->output_period_s, "period of the time series, s")
      ->check(duration)
      ->needs(schedule)
      ->capture_default_str();
  command->add_flag("--json", options->json, "as JSON");
  command->add_flag("--mesh", options->mesh, "table of the mesh's quality before the results (JSON always holds it)");
  command->add_option("--vtu", options->vtu_directory, "write the (last) field as VTU into this folder");
  command->add_option("--png", options->png_directory,
                      "draw the parts with all that acts on them, and the (last) temperature rise, into this folder");
  options->plausibility.add_to(*command);
  steady->excludes(schedule);
  uniform->excludes(steady)->excludes(schedule);
  command->callback([options] {
    const FeModel model = read_model(options->spindle_path, options->plausibility);
    // Before the solution, so that a folder that cannot be made costs no time.
    if (!options->vtu_directory.empty()) make_folder(options->vtu_directory, "--vtu");
    if (!options->png_directory.empty()) make_folder(options->png_directory, "--png");
    if (options->schedule_path.empty()) {
      run_field(model, *options);
    } else {
      run_schedule(model, *options);
    }
  });
}

}  // namespace spindle_twin::host_tools

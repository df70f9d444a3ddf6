#include <algorithm>
#include <array>
#include <cmath>
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
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/units.hpp"

// spindle-twin solve fem_offline/spindles/reference.toml --steady
namespace spindle_twin::host_tools {
namespace {

using fem_offline::AffineModel;
using fem_offline::FeModel;

constexpr double megapascal_per_pascal = 1e-6;

struct SolveOptions {
  std::string spindle_path;
  bool steady = false;
  std::string schedule_path;
  std::optional<double> uniform_rise_K;
  double max_step_s = 10.0;
  double output_period_s = 10.0;
  bool json = false;
  bool mesh = false;
  std::string vtu_directory;
  std::string png_directory;
};

struct PartRise {
  double max_K = 0.0;
  double min_K = 0.0;
};

/// What the command reports of one field, as rises above `datum_K`.
struct Report {
  double datum_K = 0.0;
  std::vector<PartRise> parts;
  std::vector<double> key_points_K;
  std::vector<double> deformation_um;
  std::vector<double> contact_pressure_MPa;
  std::vector<fem_offline::ProbedStress> stresses;
  fem_offline::HeatBalance heat;
  rom::CoolantOutlets coolant;
};

Report report_of(const AffineModel& model, const rom::BoundaryValues& values, const Eigen::VectorXd& temperatures_K,
                 double datum_K) {
  Report report;
  report.datum_K = datum_K;
  for (const auto& part : model.parts) {
    PartRise rise{-1e9, 1e9};
    for (const int dof : part.dofs) {
      rise.max_K = std::max(rise.max_K, temperatures_K[dof] - datum_K);
      rise.min_K = std::min(rise.min_K, temperatures_K[dof] - datum_K);
    }
    report.parts.push_back(rise);
  }
  for (const auto& point : model.key_points) report.key_points_K.push_back(point.row.dot(temperatures_K) - datum_K);
  const Eigen::VectorXd warmed_K = temperatures_K.array() - model.boundaries.reference_temperature_K;
  for (const auto& output : model.deformations) {
    report.deformation_um.push_back(rom::um_per_m * output.row_m_per_K.dot(warmed_K));
  }
  for (const auto& output : model.contact_pressures) {
    report.contact_pressure_MPa.push_back(megapascal_per_pascal *
                                          (output.assembly_pressure_Pa + output.row_Pa_per_K.dot(warmed_K)));
  }
  report.heat = fem_offline::heat_balance(model, values, temperatures_K);
  report.coolant = fem_offline::coolant_outlets(model, values, temperatures_K);
  return report;
}

nlohmann::json as_json(const AffineModel& model, const Report& report) {
  nlohmann::json json;
  json["spindle"] = model.spindle;
  json["unknowns"] = model.places.size();
  for (std::size_t p = 0; p < model.parts.size(); ++p) {
    json["rise_K"]["max"][model.parts[p].name] = report.parts[p].max_K;
    json["rise_K"]["min"][model.parts[p].name] = report.parts[p].min_K;
  }
  json["rise_K"]["key_points"] = report.key_points_K;
  json["deformation_um"] = nlohmann::json::object();
  for (std::size_t d = 0; d < model.deformations.size(); ++d) {
    json["deformation_um"][model.deformations[d].name] = report.deformation_um[d];
  }
  for (std::size_t c = 0; c < model.contact_pressures.size(); ++c) {
    json["contact_pressure_MPa"][model.contact_pressures[c].name] = report.contact_pressure_MPa[c];
  }
  for (const auto& [name, stress] : report.stresses) {
    json["stress_MPa"][name] = {{"rr", megapascal_per_pascal * stress.rr_Pa},
                                {"zz", megapascal_per_pascal * stress.zz_Pa},
                                {"tt", megapascal_per_pascal * stress.tt_Pa},
                                {"rz", megapascal_per_pascal * stress.rz_Pa},
                                {"von_mises", megapascal_per_pascal * fem_offline::von_mises_Pa(stress)}};
  }
  for (const auto& conductance : model.boundaries.conductances) {
    json["nominal_W_per_m2K"][conductance.name] = conductance.nominal_W_per_m2K;
  }
  for (std::size_t c = 0; c < model.boundaries.circuits.size(); ++c) {
    const auto index = static_cast<Eigen::Index>(c);
    json["coolant"][model.boundaries.circuits[c].name] = {
        {"outlet_degC", report.coolant.outlet_K[index] - rom::zero_degC_K}, {"heat_W", report.coolant.heat_W[index]}};
  }
  json["heat_in_W"] = report.heat.heat_in_W;
  json["heat_out_W"] = report.heat.heat_out_W;
  return json;
}

void print_table(const AffineModel& model, const Report& report) {
  std::printf("%s: %zu unknowns, rises above %.2f degC\n\n", model.spindle.c_str(), model.places.size(),
              report.datum_K - rom::zero_degC_K);
  std::printf("%-24s %10s %10s\n", "part", "max K", "min K");
  for (std::size_t p = 0; p < model.parts.size(); ++p) {
    std::printf("%-24s %10.3f %10.3f\n", model.parts[p].name.c_str(), report.parts[p].max_K, report.parts[p].min_K);
  }
  std::printf("\n");
  for (std::size_t k = 0; k < model.key_points.size(); ++k) {
    std::printf("%-24s %10.3f K\n", model.key_points[k].name.c_str(), report.key_points_K[k]);
  }
  for (std::size_t d = 0; d < model.deformations.size(); ++d) {
    std::printf("%-24s %10.3f um\n", model.deformations[d].name.c_str(), report.deformation_um[d]);
  }
  for (std::size_t c = 0; c < model.contact_pressures.size(); ++c) {
    std::printf("%-24s %10.3f MPa\n", model.contact_pressures[c].name.c_str(), report.contact_pressure_MPa[c]);
  }
  for (const auto& [name, stress] : report.stresses) {
    std::printf("%-24s %10.3f MPa von Mises\n", name.c_str(), megapascal_per_pascal * von_mises_Pa(stress));
  }
  for (std::size_t c = 0; c < model.boundaries.circuits.size(); ++c) {
    const auto index = static_cast<Eigen::Index>(c);
    std::printf("%-24s %10.3f W, outlet %.3f degC\n", model.boundaries.circuits[c].name.c_str(),
                report.coolant.heat_W[index], report.coolant.outlet_K[index] - rom::zero_degC_K);
  }
  std::printf("%-24s %10.3f W\n%-24s %10.3f W\n", "heat in", report.heat.heat_in_W, "heat out", report.heat.heat_out_W);
}

/// One line of the time series per output period: time, key points, part maxima, deformations.
class SeriesWriter {
 public:
  SeriesWriter(const AffineModel& model, bool json) : model_(&model), json_(json) {
    if (json_) return;
    std::printf("time_s");
    for (const auto& point : model.key_points) std::printf(",%s_K", point.name.c_str());
    for (const auto& part : model.parts) std::printf(",%s_max_K", part.name.c_str());
    for (const auto& output : model.deformations) std::printf(",%s_um", output.name.c_str());
    for (const auto& circuit : model.boundaries.circuits) {
      std::printf(",%s_outlet_degC,%s_heat_W", circuit.name.c_str(), circuit.name.c_str());
    }
    std::printf("\n");
  }

  void add(double time_s, const Report& report) {
    if (json_) {
      series_["time_s"].push_back(time_s);
      series_["key_points_K"].push_back(report.key_points_K);
      for (std::size_t p = 0; p < report.parts.size(); ++p) {
        series_["part_max_K"][model_->parts[p].name].push_back(report.parts[p].max_K);
      }
      for (std::size_t d = 0; d < report.deformation_um.size(); ++d) {
        series_["deformation_um"][model_->deformations[d].name].push_back(report.deformation_um[d]);
      }
      for (std::size_t c = 0; c < model_->boundaries.circuits.size(); ++c) {
        const auto index = static_cast<Eigen::Index>(c);
        auto& circuit = series_["coolant"][model_->boundaries.circuits[c].name];
        circuit["outlet_degC"].push_back(report.coolant.outlet_K[index] - rom::zero_degC_K);
        circuit["heat_W"].push_back(report.coolant.heat_W[index]);
      }
      return;
    }
    std::printf("%.3f", time_s);
    for (const double rise_K : report.key_points_K) std::printf(",%.4f", rise_K);
    for (const PartRise& rise : report.parts) std::printf(",%.4f", rise.max_K);
    for (const double moved_um : report.deformation_um) std::printf(",%.4f", moved_um);
    for (Eigen::Index c = 0; c < report.coolant.heat_W.size(); ++c) {
      std::printf(",%.4f,%.4f", report.coolant.outlet_K[c] - rom::zero_degC_K, report.coolant.heat_W[c]);
    }
    std::printf("\n");
  }

  const nlohmann::json& series() const { return series_; }

 private:
  const AffineModel* model_;
  bool json_;
  nlohmann::json series_;
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
         fem_offline::write_pictures(options.png_directory, name, model, temperatures_K, shown)) {
      std::fprintf(stderr, "picture in %s\n", path.c_str());
    }
  }
}

/// Starts at the schedule's first ambient temperature, except parts with an initial temperature of their own, and
/// reports rises above it.
void run_schedule(const FeModel& model, const SolveOptions& options) {
  const AffineModel& affine = model.affine();
  if (affine.imposed_rises_K) {
    throw rom::InputError({options.spindle_path, 0}, "imposed_temperature",
                          "the temperatures are given, so nothing changes along a schedule");
  }
  const rom::Schedule schedule = rom::read_schedule(options.schedule_path, affine.boundaries);
  const rom::CorrectionFactors factors = rom::no_correction(affine.boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(affine.boundaries);
  rom::OperatingState state = affine.boundaries.operating;
  rom::state_at(schedule, 0.0, state);
  rom::evaluate_boundaries(affine.boundaries, state, factors, values);
  const double start_K = rom::rest_temperature_K(affine.boundaries, state);

  fem_offline::FeStepper stepper(affine);
  stepper.set_temperatures(fem_offline::initial_temperatures(affine, start_K));
  SeriesWriter writer(affine, options.json);
  writer.add(0.0, report_of(affine, values, stepper.temperatures_K(), start_K));
  double time_s = 0.0;
  for (long next_output = 1; time_s < schedule.end_s; ++next_output) {
    const double until_s = std::min(schedule.end_s, static_cast<double>(next_output) * options.output_period_s);
    fem_offline::follow_schedule(affine.boundaries, schedule, time_s, until_s, options.max_step_s, stepper, values);
    time_s = until_s;
    writer.add(time_s, report_of(affine, values, stepper.temperatures_K(), start_K));
  }
  if (options.json) {
    Report report = report_of(affine, values, stepper.temperatures_K(), start_K);
    report.stresses = model.probed_stresses(stepper.temperatures_K());
    nlohmann::json json = as_json(affine, report);
    json["mesh"] = mesh_json(model.quality());
    json["series"] = writer.series();
    std::printf("%s\n", json.dump(2).c_str());
  }
  std::array<char, 32> after{};
  std::snprintf(after.data(), after.size(), "after %g s: ", schedule.end_s);
  write_fields(model, options, stepper.temperatures_K(), {after.data() + printed(affine.boundaries, state), start_K});
}

void run_field(const FeModel& model, const SolveOptions& options) {
  const AffineModel& affine = model.affine();
  rom::BoundaryValues values = rom::make_boundary_values(affine.boundaries);
  rom::evaluate_boundaries(affine.boundaries, affine.boundaries.operating, rom::no_correction(affine.boundaries),
                           values);
  Eigen::VectorXd temperatures_K;
  double datum_K = rom::rest_temperature_K(affine.boundaries, affine.boundaries.operating);
  if (options.uniform_rise_K) {
    datum_K = affine.boundaries.reference_temperature_K;
    temperatures_K =
        Eigen::VectorXd::Constant(static_cast<Eigen::Index>(affine.places.size()), datum_K + *options.uniform_rise_K);
  } else {
    temperatures_K = fem_offline::solve_steady(affine, values);
  }
  if (affine.imposed_rises_K) datum_K = affine.boundaries.reference_temperature_K;
  if (options.uniform_rise_K || affine.imposed_rises_K) {
    // No heat flows to speak of: the field is given, not solved for.
    values.heat_W.setZero();
    values.conductance_W_per_m2K.setZero();
  }
  Report report = report_of(affine, values, temperatures_K, datum_K);
  if (!affine.imposed_rises_K && !options.uniform_rise_K) {
    report.heat = fem_offline::steady_heat_balance(affine, values, temperatures_K);
  }
  report.stresses = model.probed_stresses(temperatures_K);
  if (options.json) {
    nlohmann::json json = as_json(affine, report);
    json["mesh"] = mesh_json(model.quality());
    std::printf("%s\n", json.dump(2).c_str());
  } else {
    if (options.mesh) print_mesh_table(model.quality());
    print_table(affine, report);
  }
  const std::string title = options.uniform_rise_K ? "uniform rise, no heat flows"
                            : affine.imposed_rises_K
                                ? "imposed temperatures"
                                : "steady state: " + printed(affine.boundaries, affine.boundaries.operating);
  write_fields(model, options, temperatures_K, {title, datum_K});
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
  command->add_option("--max-step", options->max_step_s, "longest time step along a schedule, s")
      ->check(duration)
      ->needs(schedule)
      ->capture_default_str();
  command->add_option("--output-period", options->output_period_s, "period of the time series, s")
      ->check(duration)
      ->needs(schedule)
      ->capture_default_str();
  command->add_flag("--json", options->json, "as JSON");
  command->add_flag("--mesh", options->mesh, "table of the mesh's quality before the results (JSON always holds it)");
  command->add_option("--vtu", options->vtu_directory, "write the (last) field as VTU into this folder");
  command->add_option("--png", options->png_directory,
                      "draw the parts with all that acts on them, and the (last) temperature rise, into this folder");
  steady->excludes(schedule);
  uniform->excludes(steady)->excludes(schedule);
  command->callback([options] {
    const FeModel model = fem_offline::build_fe_model(options->spindle_path);
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

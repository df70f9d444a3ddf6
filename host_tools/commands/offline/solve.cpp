#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "correction/boundaries/evaluate_boundaries.hpp"
#include "correction/boundaries/schedule.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "host_tools/commands/commands.hpp"

// spindle-twin solve fem_offline/spindles/reference.toml --steady
namespace spindle_twin::host_tools {
namespace {

using fem_offline::AffineModel;
using fem_offline::FeModel;

constexpr double micrometres_per_metre = 1e6;

struct SolveOptions {
  std::string spindle_path;
  bool steady = false;
  std::string schedule_path;
  std::optional<double> uniform_rise_K;
  double max_step_s = 10.0;
  double output_period_s = 10.0;
  bool json = false;
  std::string vtu_directory;
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
  fem_offline::HeatBalance heat;
};

/// The first ambient environment, where a spindle at rest ends; the first of all if none is ambient.
double ambient_K(const rom::Boundaries& boundaries, const rom::OperatingState& state) {
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    if (boundaries.environments[i].kind == rom::EnvironmentKind::ambient) {
      return state.environment_K[static_cast<Eigen::Index>(i)];
    }
  }
  return state.environment_K.size() > 0 ? state.environment_K[0] : boundaries.reference_temperature_K;
}

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
    report.deformation_um.push_back(micrometres_per_metre * output.row_m_per_K.dot(warmed_K));
  }
  report.heat = fem_offline::heat_balance(model, values, temperatures_K);
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
  json["heat_in_W"] = report.heat.heat_in_W;
  json["heat_out_W"] = report.heat.heat_out_W;
  return json;
}

void print_table(const AffineModel& model, const Report& report) {
  std::printf("%s: %zu unknowns, rises above %.2f degC\n\n", model.spindle.c_str(), model.places.size(),
              report.datum_K - 273.15);
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
      return;
    }
    std::printf("%.3f", time_s);
    for (const double rise_K : report.key_points_K) std::printf(",%.4f", rise_K);
    for (const PartRise& rise : report.parts) std::printf(",%.4f", rise.max_K);
    for (const double moved_um : report.deformation_um) std::printf(",%.4f", moved_um);
    std::printf("\n");
  }

  const nlohmann::json& series() const { return series_; }

 private:
  const AffineModel* model_;
  bool json_;
  nlohmann::json series_;
};

void write_fields(const FeModel& model, const SolveOptions& options, const Eigen::VectorXd& temperatures_K) {
  if (options.vtu_directory.empty()) return;
  std::error_code failure;
  std::filesystem::create_directories(options.vtu_directory, failure);
  if (failure)
    throw rom::InputError({options.vtu_directory, 0}, "--vtu", "no folder can be made: " + failure.message());
  const std::string name = std::filesystem::path(options.spindle_path).stem().string();
  model.write_vtu(options.vtu_directory, name, temperatures_K);
  std::fprintf(stderr, "fields in %s/%s.vtu\n", options.vtu_directory.c_str(), name.c_str());
}

/// Starts everywhere at the schedule's first ambient temperature and reports rises above it.
void run_schedule(const FeModel& model, const SolveOptions& options) {
  const AffineModel& affine = model.affine();
  const correction::Schedule schedule = correction::read_schedule(options.schedule_path, affine.boundaries);
  const rom::CorrectionFactors factors = correction::no_correction(affine.boundaries);
  rom::BoundaryValues values = correction::make_boundary_values(affine.boundaries);
  rom::OperatingState state = affine.boundaries.operating;
  correction::state_at(schedule, 0.0, state);
  correction::evaluate_boundaries(affine.boundaries, state, factors, values);
  const double start_K = ambient_K(affine.boundaries, state);

  fem_offline::FeStepper stepper(affine);
  stepper.set_uniform_temperature(start_K);
  SeriesWriter writer(affine, options.json);
  writer.add(0.0, report_of(affine, values, stepper.temperatures_K(), start_K));
  double time_s = 0.0;
  std::size_t next_row = 1;
  long next_output = 1;
  while (time_s < schedule.end_s) {
    // Inputs are held over a step at their value in its middle, and jump only between steps.
    while (next_row < schedule.rows.size() && schedule.rows[next_row].time_s <= time_s) ++next_row;
    const double row_s = next_row < schedule.rows.size() ? schedule.rows[next_row].time_s : schedule.end_s;
    const double output_s = std::min(schedule.end_s, static_cast<double>(next_output) * options.output_period_s);
    const double until_s = std::min(row_s, output_s);
    correction::state_at(schedule, 0.5 * (time_s + until_s), state);
    correction::evaluate_boundaries(affine.boundaries, state, factors, values);
    stepper.advance(until_s - time_s, options.max_step_s, values);
    time_s = until_s;
    if (time_s < output_s) continue;
    ++next_output;
    writer.add(time_s, report_of(affine, values, stepper.temperatures_K(), start_K));
  }
  if (options.json) {
    nlohmann::json json = as_json(affine, report_of(affine, values, stepper.temperatures_K(), start_K));
    json["series"] = writer.series();
    std::printf("%s\n", json.dump(2).c_str());
  }
  write_fields(model, options, stepper.temperatures_K());
}

void run_field(const FeModel& model, const SolveOptions& options) {
  const AffineModel& affine = model.affine();
  rom::BoundaryValues values = correction::make_boundary_values(affine.boundaries);
  correction::evaluate_boundaries(affine.boundaries, affine.boundaries.operating,
                                  correction::no_correction(affine.boundaries), values);
  Eigen::VectorXd temperatures_K;
  double datum_K = ambient_K(affine.boundaries, affine.boundaries.operating);
  if (options.uniform_rise_K) {
    datum_K = affine.boundaries.reference_temperature_K;
    temperatures_K =
        Eigen::VectorXd::Constant(static_cast<Eigen::Index>(affine.places.size()), datum_K + *options.uniform_rise_K);
    // No heat flows to speak of: the field is given, not solved for.
    values.heat_W.setZero();
    values.conductance_W_per_m2K.setZero();
  } else {
    temperatures_K = fem_offline::solve_steady(affine, values);
  }
  const Report report = report_of(affine, values, temperatures_K, datum_K);
  if (options.json) {
    std::printf("%s\n", as_json(affine, report).dump(2).c_str());
  } else {
    print_table(affine, report);
  }
  write_fields(model, options, temperatures_K);
}

}  // namespace

void add_solve(CLI::App& app) {
  auto options = std::make_shared<SolveOptions>();
  CLI::App* command = app.add_subcommand("solve", "Solve the FE model: steady (default) or along a schedule");
  command->add_option("spindle", options->spindle_path, "spindle description (TOML)")->required();
  auto* steady = command->add_flag("--steady", options->steady, "steady state at the description's operating state");
  auto* schedule = command->add_option("--schedule", options->schedule_path,
                                       "CSV time_s,speed_rpm,load[,<environment>_degC]; prints a time series");
  auto* uniform = command->add_option("--uniform-rise-K", options->uniform_rise_K,
                                      "deformation of a uniform rise above the reference temperature");
  command->add_option("--max-step", options->max_step_s, "longest time step, s")->check(CLI::PositiveNumber);
  command->add_option("--output-period", options->output_period_s, "period of the time series, s")
      ->check(CLI::PositiveNumber);
  command->add_flag("--json", options->json, "print JSON instead of a table");
  command->add_option("--vtu", options->vtu_directory, "write the (last) field as VTU into this folder");
  steady->excludes(schedule);
  uniform->excludes(steady)->excludes(schedule);
  command->callback([options] {
    const FeModel model = fem_offline::build_fe_model(options->spindle_path);
    if (options->schedule_path.empty()) {
      run_field(model, *options);
    } else {
      run_schedule(model, *options);
    }
  });
}

}  // namespace spindle_twin::host_tools

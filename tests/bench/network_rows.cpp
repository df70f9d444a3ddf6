#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "fem_offline/reduce/choose_size.hpp"
#include "fem_offline/reduce/verify.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "tests/bench/rows.hpp"

namespace spindle_twin::bench {
namespace {

constexpr int seconds_per_hour = 3600;

/// The second hour of the operating state in cycles of 1 s.
double seconds_of_held_hour(const rom::Network& network) {
  const rom::Boundaries& boundaries = network.boundaries;
  rom::CvodeStepper stepper(std::make_shared<const rom::NetworkOperator>(network));
  const rom::CorrectionFactors factors = rom::no_correction(boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  const auto run_an_hour = [&] {
    for (int second = 0; second < seconds_per_hour; ++second) {
      rom::evaluate_boundaries(boundaries, boundaries.operating, factors, values);
      stepper.advance(1.0, values);
    }
  };
  run_an_hour();
  return thread_seconds(1, run_an_hour);
}

/// Runs `advance(values, period_s)` over an hour in steps of `period_s`.
template <class Advance>
void drive_an_hour(const rom::Boundaries& boundaries, int period_s, const Advance& advance) {
  const rom::CorrectionFactors factors = rom::no_correction(boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::OperatingState state = boundaries.operating;
  for (int second = 0; second < seconds_per_hour; second += period_s) {
    const Drive drive = drive_at(second);
    state.speed_rpm = drive.speed_rpm;
    state.load = drive.load;
    rom::evaluate_boundaries(boundaries, state, factors, values);
    advance(values, static_cast<double>(period_s));
  }
}

/// `spindle-twin build` without options: size by the default tolerance, certificate of 20 cases. Processor seconds.
struct DefaultBuild {
  rom::Network network;
  double size_s = 0.0;         ///< snapshots, basis and search
  double certificate_s = 0.0;  ///< cases of the certificate
};

DefaultBuild build_by_default(const fem_offline::AffineModel& model) {
  fem_offline::ReduceOptions options;
  options.nodes = std::min(fem_offline::largest_size, static_cast<int>(model.capacity_J_per_K.rows()));
  options.box.speed_high_rpm = std::max(options.box.speed_high_rpm, 4.0 / 3.0 * model.boundaries.reference_speed_rpm);
  DefaultBuild built;
  built.size_s = process_seconds([&] {
    const fem_offline::Reduction reduction(model, options);
    built.network = fem_offline::choose_size(model, reduction, {}, options).network;
  });
  fem_offline::VerifyOptions verify;
  verify.drive.box = options.box;
  built.certificate_s = process_seconds([&] { fem_offline::verify_network(built.network, model, verify); });
  return built;
}

/// The hour in calls of `period_s`, with steps of `longest_step_s` at most.
double seconds_of_fe_hour(const fem_offline::AffineModel& model, int period_s, double longest_step_s) {
  fem_offline::FeStepper stepper(model);
  return thread_seconds(1, [&] {
    drive_an_hour(model.boundaries, period_s, [&](const rom::BoundaryValues& values, double seconds) {
      stepper.advance(seconds, longest_step_s, values);
    });
  });
}

/// Seconds of the same spindle as FE model and as network.
struct NetworkTimes {
  double model_s = 0.0;         ///< mesh and assembly
  double steady_s = 0.0;        ///< one steady FE solution: sum, analysis, factorisation, two solves
  double network_hour_s = 0.0;  ///< drive cycle in cycles of 1 s
  double held_hour_s = 0.0;     ///< the same with inputs that stand still
  double fe_hour_s = 0.0;       ///< FE model, cycles of 1 s
  double free_fe_hour_s = 0.0;  ///< FE model, steps up to 10 s
  double product_s = 0.0;       ///< one bare matrix-vector product of the network's size
};

void print_rows(const RowPrinter& printer, const DefaultBuild& built, std::size_t unknowns, const NetworkTimes& took) {
  const auto print = [&](const std::string& name, double ours_s, const char* kind, const char* other, double other_s,
                         const char* means, std::optional<double> goal = {}, bool detail = false) {
    printer.print({.group = "Network",
                   .name = name,
                   .kind = kind,
                   .ours_s = ours_s,
                   .other_name = other,
                   .other_s = other_s,
                   .means = means,
                   .goal = goal,
                   .detail = detail});
  };
  const std::string size = std::to_string(built.network.nodes.size()) + " nodes from " +
                           with_commas(static_cast<long>(unknowns)) + " unknowns";
  const char *one_solution = "one steady FE solution", *product = "one bare matrix-vector product";
  print("build with default options, " + size, took.model_s + built.size_s, "bound", one_solution, took.steady_s,
        "How many FE solutions the snapshots, the basis and the search for the size are worth.", {}, true);
  print("its certificate of 20 drive cycles of 1 to 2 h", built.certificate_s, "bound", one_solution, took.steady_s,
        "FE transients that the network is held against.", {}, true);
  print("an hour of a drive cycle in cycles of 1 s", took.network_hour_s, "peer", "our FE model, cycles of 1 s",
        took.fe_hour_s, "The network's own duty: inputs and outputs each second, a new matrix whenever a film changes.",
        1.0 / 2000.0);
  print("the same hour", took.network_hour_s, "peer", "our FE model, steps up to 10 s", took.free_fe_hour_s,
        "The FE model knows two minutes of inputs in advance, as no twin beside a machine could.");
  print("one cycle of that hour, inputs that jump", took.network_hour_s / seconds_per_hour, "bound", product,
        took.product_s, "What integration with error control costs.");
  print("one cycle, inputs held", took.held_hour_s / seconds_per_hour, "bound", product, took.product_s,
        "The same where nothing changes.", 10.0);
}

}  // namespace

void print_network_rows(const RowPrinter& printer) {
  constexpr double element_size_mm = 4.0;
  NetworkTimes took;
  std::unique_ptr<fem_offline::FeModel> model;
  took.model_s =
      process_seconds([&] { model = std::make_unique<fem_offline::FeModel>(reference_model(element_size_mm, false)); });
  const fem_offline::AffineModel& affine = model->affine();
  rom::BoundaryValues operating = rom::make_boundary_values(affine.boundaries);
  rom::evaluate_boundaries(affine.boundaries, affine.boundaries.operating, rom::no_correction(affine.boundaries),
                           operating);
  took.steady_s = thread_seconds(10, [&] { fem_offline::solve_steady(affine, operating); });
  const DefaultBuild built = build_by_default(affine);

  rom::CvodeStepper fast(std::make_shared<const rom::NetworkOperator>(built.network));
  took.network_hour_s = thread_seconds(1, [&] {
    drive_an_hour(built.network.boundaries, 1,
                  [&](const rom::BoundaryValues& values, double period_s) { fast.advance(period_s, values); });
  });
  took.held_hour_s = seconds_of_held_hour(built.network);
  took.fe_hour_s = seconds_of_fe_hour(affine, 1, 1.0);
  took.free_fe_hour_s = seconds_of_fe_hour(affine, held_s, 10.0);
  took.product_s = bare_product_seconds(static_cast<Eigen::Index>(built.network.nodes.size()));
  print_rows(printer, built, affine.places.size(), took);
}

double schedule_seconds(const std::string& network_path, const std::string& schedule_path) {
  const rom::Network network = rom::read_network(network_path);
  const rom::Boundaries& boundaries = network.boundaries;
  const rom::Schedule schedule = rom::read_schedule(schedule_path, boundaries);
  const rom::CorrectionFactors factors = rom::no_correction(boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::OperatingState state = boundaries.operating;
  rom::CvodeStepper stepper(std::make_shared<const rom::NetworkOperator>(network));
  return thread_seconds(1, [&] {
    for (double time_s = 0.0; time_s < schedule.end_s; time_s += 1.0) {
      rom::state_at(schedule, time_s + 0.5, state);
      rom::evaluate_boundaries(boundaries, state, factors, values);
      stepper.advance(1.0, values);
    }
  });
}

}  // namespace spindle_twin::bench

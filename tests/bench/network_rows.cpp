#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

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
constexpr int held_s = 120;

/// A part program: another speed and load every two minutes.
void at_second(int second, rom::OperatingState& state) {
  constexpr std::array<double, 6> speed_rpm{6000, 9000, 3000, 12000, 0, 7500};
  constexpr std::array<double, 5> load{1.0, 0.4, 0.7, 0.0, 0.9};
  const auto block = static_cast<std::size_t>(second / held_s);
  state.speed_rpm = speed_rpm[block % speed_rpm.size()];
  state.load = load[block % load.size()];
}

/// Seconds of as many matrix-vector products as an hour has cycles, with a full matrix of the network's size.
double seconds_of_bare_products(Eigen::Index nodes) {
  const Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(nodes, nodes) * 0.5;
  Eigen::VectorXd vector = Eigen::VectorXd::Ones(nodes), product(nodes);
  return thread_seconds(3, [&] {
    for (int i = 0; i < seconds_per_hour; ++i) {
      product.noalias() = dense * vector;
      vector.swap(product);
    }
  });
}

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
    at_second(second, state);
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

}  // namespace

void print_network_rows() {
  constexpr double element_size_mm = 4.0;
  std::unique_ptr<fem_offline::FeModel> model;
  const double model_s =
      process_seconds([&] { model = std::make_unique<fem_offline::FeModel>(reference_model(element_size_mm, false)); });
  const fem_offline::AffineModel& affine = model->affine();
  rom::BoundaryValues operating = rom::make_boundary_values(affine.boundaries);
  rom::evaluate_boundaries(affine.boundaries, affine.boundaries.operating, rom::no_correction(affine.boundaries),
                           operating);
  const double steady_s = thread_seconds(3, [&] { fem_offline::solve_steady(affine, operating); });
  const DefaultBuild built = build_by_default(affine);
  const rom::Network& network = built.network;

  rom::CvodeStepper fast(std::make_shared<const rom::NetworkOperator>(network));
  const double network_s = thread_seconds(1, [&] {
    drive_an_hour(network.boundaries, 1,
                  [&](const rom::BoundaryValues& values, double period_s) { fast.advance(period_s, values); });
  });
  const double coarse_s = seconds_of_fe_hour(affine, held_s, 10.0);
  const double fine_s = seconds_of_fe_hour(affine, 1, 1.0);
  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  const double products_s = seconds_of_bare_products(nodes);
  const double held_hour_s = seconds_of_held_hour(network);

  std::printf("network of %ld nodes from %zu unknowns (element size %g mm)\n", static_cast<long>(nodes),
              affine.places.size(), element_size_mm);
  print_row("one steady FE solve (sum, analysis, factorisation, 2 solves)", steady_s, "s");
  print_row("default build, without certificate / steady FE solves", (model_s + built.size_s) / steady_s, "x");
  print_row("  its certificate of 20 cases of 1 to 2 h / steady FE solves", built.certificate_s / steady_s, "x");
  print_row("  both", model_s + built.size_s + built.certificate_s, "s", "goal below 600 (5 min on 2 cores)");
  print_row("drive cycle of one hour: network, cycles of 1 s", network_s, "s");
  print_row("  one of its cycles", 1e6 * network_s / seconds_per_hour, "us");
  print_row("FE transient in cycles of 1 s / network", fine_s / network_s, "x", "goal 2000");
  print_row("FE transient, steps up to 10 s / network", coarse_s / network_s, "x");
  print_row("network / 3600 bare matrix-vector products of its size", network_s / products_s, "x");
  print_row("the same with inputs held", held_hour_s / products_s, "x", "goal below 10");
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

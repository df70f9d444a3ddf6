#include "tests/bench/commissioning/wrong_models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include "tests/bench/commissioning/limits.hpp"

namespace spindle_twin::bench {
namespace {

constexpr int six = 6;                                // sensors
constexpr double cutting_W = 25.0, guessed_W = 20.0;  // what cuts, and what a description supposes
constexpr double displaced_m = 0.010;
constexpr const char* cutting_name = "heat cutting";

enum class Case { healthy, structure, cutting_untold, cutting_told, displaced };
constexpr std::array cases{Case::healthy, Case::structure, Case::cutting_untold, Case::cutting_told, Case::displaced};
constexpr std::array<const char*, cases.size()> case_names{"healthy", "conductivity -10 %, expansion +10 %",
                                                           "25 W at the nose, untold", "25 W at the nose, told",
                                                           "a sensor 10 mm off"};

bool cuts(Case which) { return which == Case::cutting_untold || which == Case::cutting_told; }

/// The machine's structure; `displaced`: which sensor sits 10 mm further back than the twin believes.
fem_offline::FeModel truth_of(Case which, double element_size_mm, std::size_t displaced) {
  return model_of(element_size_mm, [&](fem_offline::Spindle& spindle) {
    if (cuts(which)) add_cutting_heat(spindle, cutting_W);
    if (which == Case::displaced) spindle.key_points[displaced].at.z_m += displaced_m;
    if (which != Case::structure) return;
    for (fem_offline::Material& material : spindle.materials) {
      material.conductivity_r_W_per_mK *= 0.9;
      material.conductivity_z_W_per_mK *= 0.9;
      material.expansion_per_K *= 1.1;
    }
  });
}

struct Outcome {
  Score day;
  double hold_out_um = 0.0;
  double asked_deviations = 0.0;                              ///< of the surest heat that no source explains
  bool reported = false;                                      ///< by the hold-out test
  double found_W = std::numeric_limits<double>::quiet_NaN();  ///< at the nose
};

bool is_of_hold_out(const std::string& misfit) { return misfit.find("held out") != std::string::npos; }

/// Readings that ask for a heat which no source explains.
bool is_asked_for(const Outcome& outcome) {
  return outcome.asked_deviations > correction::CalibrateLimits{}.asked_heat;
}

double found_cutting_W(const correction::Calibration& found) {
  for (std::size_t i = 0; i < found.names.size(); ++i) {
    if (found.names[i] == cutting_name) return guessed_W * std::exp(found.mean[static_cast<Eigen::Index>(i)]);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// One machine: test, fit, and a day of service. `twin`: the network that is fitted; `machine`: the truth's FE model.
Outcome commission_wrong(const rom::Network& twin, const fem_offline::AffineModel& machine,
                         const correction::ParameterModel& parameters, const Eigen::VectorXd& theta, std::uint64_t seed,
                         const TestPlan& plan) {
  constexpr HeatErrors heats = HeatErrors::independent;
  Conditions of_test = conditions_of_test(plan);
  of_test.theta = theta;
  const Truth tested = make_truth(machine, parameters, seed, heats, of_test);
  const correction::CalibrationResult found =
      correction::calibrate(twin, calibrate_options(twin, six, heats), {log_of(twin, tested, six, plan)}, {});
  Outcome outcome;
  if (!found.asked.empty()) outcome.asked_deviations = found.asked.front().deviations();
  outcome.hold_out_um = probe_rms_um(found.held_out.channels, six);
  outcome.reported = std::any_of(found.misfits.begin(), found.misfits.end(), is_of_hold_out);
  outcome.found_W = found_cutting_W(found.calibration);

  const Drifted& by = drifts.front();
  const Conditions of_day = conditions_of_day(plan, drifted(parameters, theta, by, seed + day_stream));
  const Truth truth = make_truth(machine, parameters, seed + day_stream, heats, of_day);
  correction::EstimatorOptions options;
  options.priors = priors_of(heats);
  options.priors.calibrated = correction::prior_of(found.calibration, {by.heat, by.contact, by.film});
  outcome.day = run_estimator(twin, truth, six, false, options);
  return outcome;
}

using Machines = std::vector<std::array<Outcome, cases.size()>>;

template <class What>
std::vector<double> of_case(const Machines& machines, Case which, const What& what) {
  std::vector<double> values;
  for (const auto& machine : machines) values.push_back(what(machine[static_cast<std::size_t>(which)]));
  return values;
}

double error_um(const Outcome& outcome) { return outcome.day.error_um; }
double is_reported(const Outcome& outcome) { return outcome.reported ? 1.0 : 0.0; }
double is_asked(const Outcome& outcome) { return is_asked_for(outcome) ? 1.0 : 0.0; }
double share_off(const Outcome& outcome) { return std::abs(outcome.found_W / cutting_W - 1.0); }

void print_table(const Machines& machines) {
  std::printf("\n  %-38s %7s %7s %7s %9s %9s  %s\n", "nose on another day, um", "median", "worst", "inside", "hold-out",
              "reported", "heat asked for, largest in its sigma");
  for (const Case which : cases) {
    const std::vector<double> errors = of_case(machines, which, error_um);
    const double count = static_cast<double>(machines.size());
    std::printf("  %-38s %7.2f %7.2f %7.3f %9.2f %4.0f of %zu  %4.0f of %zu, %.1f\n",
                case_names[static_cast<std::size_t>(which)], median_of(errors), worst_of(errors),
                mean_of(of_case(machines, which, [](const Outcome& each) { return each.day.inside; })),
                median_of(of_case(machines, which, [](const Outcome& each) { return each.hold_out_um; })),
                count * mean_of(of_case(machines, which, is_reported)), machines.size(),
                count * mean_of(of_case(machines, which, is_asked)), machines.size(),
                worst_of(of_case(machines, which, [](const Outcome& each) { return each.asked_deviations; })));
  }
  std::printf("  found at the nose once told:");
  for (const double watts : of_case(machines, Case::cutting_told, [](const Outcome& each) { return each.found_W; })) {
    std::printf(" %.1f W", watts);
  }
  std::printf("\n");
}

int print_limits(const Machines& machines) {
  const auto median = [&](Case which) { return median_of(of_case(machines, which, error_um)); };
  const double healthy_um = median(Case::healthy);
  std::printf("\nlimits\n");
  int missed =
      limit("conductivity, expansion: median, of a healthy model's", median(Case::structure) / healthy_um, 1.3);
  missed += limit("25 W untold: share of machines where the hold-out reports it",
                  mean_of(of_case(machines, Case::cutting_untold, is_reported)), 2.0 / 3.0, true);
  missed += limit("25 W untold: share of machines whose readings ask for a heat",
                  mean_of(of_case(machines, Case::cutting_untold, is_asked)), 2.0 / 3.0, true);
  for (const Case which : {Case::healthy, Case::structure, Case::cutting_told, Case::displaced}) {
    const std::string what =
        std::string("asked for although there is none: ") + case_names[static_cast<std::size_t>(which)];
    missed += limit(what.c_str(), mean_of(of_case(machines, which, is_asked)), 0.0);
  }
  missed += limit("25 W told: found, off by, median", median_of(of_case(machines, Case::cutting_told, share_off)), 0.1);
  missed += limit("25 W told: median, um", median(Case::cutting_told), 0.8);
  missed += limit("a sensor 10 mm off: median, of a healthy model's", median(Case::displaced) / healthy_um, 1.3);
  std::printf("%d limits missed\n", missed);
  return missed;
}

}  // namespace

int check_wrong_models(const CampaignOptions& options, const TestPlan& plan) {
  const rom::Network plain = twin_network(options.twin);
  TwinOptions with_heat = options.twin;
  with_heat.variant = "_cutting";
  with_heat.change = [](fem_offline::Spindle& spindle) { add_cutting_heat(spindle, guessed_W); };
  const rom::Network told = twin_network(with_heat);
  const correction::EstimatorPriors priors = priors_of(HeatErrors::independent);
  const correction::ParameterModel of_plain(plain, priors), of_told(told, priors);
  const fem_offline::FeModel healthy = model_of(options.truth_mm);

  Machines machines(static_cast<std::size_t>(options.runs));
  std::mutex meshing;  // the mesher has one state for the whole program
  const int jobs = options.runs * static_cast<int>(cases.size());
  in_parallel(options.twin.threads, jobs, [&](int job) {
    const auto m = static_cast<std::size_t>(job) / cases.size(), c = static_cast<std::size_t>(job) % cases.size();
    const Case which = cases[c];
    const std::uint64_t seed = seed_of(options, static_cast<int>(m), HeatErrors::independent);
    Conditions begun = conditions_of_test(plan);
    begun.run_s = begun.sample_s;  // only its draw of hidden parameters
    const Eigen::VectorXd theta = make_truth(healthy.affine(), of_plain, seed, HeatErrors::independent, begun).theta;
    const correction::ParameterModel& of_machine = cuts(which) ? of_told : of_plain;
    std::unique_lock lock(meshing);
    const fem_offline::FeModel machine = truth_of(which, options.truth_mm, m % six);
    lock.unlock();
    machines[m][c] = commission_wrong(which == Case::cutting_told ? told : plain, machine.affine(), of_machine,
                                      of_plain.as_in(of_machine, theta), seed, plan);
    const Outcome& outcome = machines[m][c];
    lock.lock();
    std::fprintf(stderr, "%llu, %s: nose %.2f um (inside %.2f), held out %.2f um%s, asked %.1f sigma, found %.1f W\n",
                 static_cast<unsigned long long>(seed), case_names[c], outcome.day.error_um, outcome.day.inside,
                 outcome.hold_out_um, outcome.reported ? " (reported)" : "", outcome.asked_deviations, outcome.found_W);
  });
  print_table(machines);
  return print_limits(machines);
}

}  // namespace spindle_twin::bench

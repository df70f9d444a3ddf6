#include "fem_offline/verify_cases/fem_case.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>

#include "fem_offline/solve/fe_solver.hpp"
#include "fem_offline/solve/follow_schedule.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double largest_imbalance = 1e-9;

/// A field with the inputs that hold beside it.
struct Instant {
  Eigen::VectorXd temperatures_K;
  rom::BoundaryValues values;
};

template <typename Item>
std::size_t place_of(const std::vector<Item>& items, const std::string& name) {
  const auto found = std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  if (found == items.end()) throw std::logic_error("nothing is named " + name);
  return static_cast<std::size_t>(found - items.begin());
}

/// Heat from side A to side B, or into the environment. [W]
double exchanged_W(const AffineModel& model, const Instant& instant, std::size_t index) {
  const rom::Conductance& conductance = model.boundaries.conductances[index];
  Eigen::VectorXd above_K = instant.temperatures_K;
  if (conductance.environment >= 0) above_K.array() -= instant.values.environment_K[conductance.environment];
  const Eigen::VectorXd leaving = model.conductance_terms_m2[index] * above_K;
  double sum_m2K = 0.0;
  for (std::size_t i = 0; i < model.places.size(); ++i) {
    const int part = model.places[i].part;
    // Between two parts one side's share is the heat; all other kinds take from every part they touch.
    const bool counts = conductance.part_b >= 0 ? part == conductance.part_a : part >= 0;
    if (counts) sum_m2K += leaving[static_cast<Eigen::Index>(i)];
  }
  return instant.values.conductance_W_per_m2K[static_cast<Eigen::Index>(index)] * sum_m2K;
}

double stress_MPa(const FeModel& fe, const Instant& instant, const Expectation& expected) {
  const std::vector<ProbedStress> probed = fe.probed_stresses(instant.temperatures_K);
  const Stress& stress = probed[place_of(probed, expected.of)].stress;
  const double stress_Pa = expected.quantity == "stress_rr_MPa"   ? stress.rr_Pa
                           : expected.quantity == "stress_zz_MPa" ? stress.zz_Pa
                           : expected.quantity == "stress_tt_MPa" ? stress.tt_Pa
                                                                  : stress.rz_Pa;
  return 1e-6 * stress_Pa;
}

double figure_of(const FeModel& fe, const Instant& instant, const Expectation& expected) {
  const AffineModel& model = fe.affine();
  if (expected.quantity.starts_with("stress_")) return stress_MPa(fe, instant, expected);
  if (expected.quantity == "temperature_degC") {
    return model.key_points[place_of(model.key_points, expected.of)].row.dot(instant.temperatures_K) - rom::zero_degC_K;
  }
  if (expected.quantity == "deformation_um") {
    const Eigen::VectorXd rises_K = instant.temperatures_K.array() - model.boundaries.reference_temperature_K;
    return rom::um_per_m * model.deformations[place_of(model.deformations, expected.of)].row_m_per_K.dot(rises_K);
  }
  const std::size_t index = place_of(model.boundaries.conductances, expected.of);
  const double heat_W = exchanged_W(model, instant, index);
  return expected.quantity == "heat_W" ? heat_W : heat_W / model.boundaries.conductances[index].area_m2;
}

/// The steady field, or the one that the description imposes.
Instant steady(const AffineModel& model) {
  Instant instant;
  instant.values = rom::make_boundary_values(model.boundaries);
  rom::evaluate_boundaries(model.boundaries, model.boundaries.operating, rom::no_correction(model.boundaries),
                           instant.values);
  if (model.imposed_rises_K) {
    instant.temperatures_K = model.imposed_rises_K->array() + model.boundaries.reference_temperature_K;
  } else {
    instant.temperatures_K = solve_steady(model, instant.values);
  }
  return instant;
}

/// The instants asked for, from the initial temperatures on.
std::map<double, Instant> along_schedule(const AffineModel& model, const Verification& verification) {
  std::map<double, Instant> instants;
  for (const Expectation& expected : verification.expectations) {
    if (expected.time_s) instants[*expected.time_s];
  }
  if (instants.empty()) return instants;
  const rom::Schedule schedule = verification.schedule.empty()
                                     ? rom::constant_schedule(model.boundaries, instants.rbegin()->first)
                                     : rom::read_schedule(verification.schedule, model.boundaries);
  FeStepper stepper(model);
  double time_s = 0.0;
  for (auto& [until_s, instant] : instants) {
    instant.values = rom::make_boundary_values(model.boundaries);
    follow_schedule(model.boundaries, schedule, {time_s, until_s, verification.max_step_s}, stepper, instant.values);
    instant.temperatures_K = stepper.temperatures_K();
    time_s = until_s;
  }
  return instants;
}

CheckedFigure check(const Expectation& expected, double result, double span_K) {
  CheckedFigure figure;
  // "stress_zz_MPa" has its unit at the end, "flux_W_per_m2" after the first word.
  const std::size_t unit_at =
      expected.quantity.starts_with("stress_") ? expected.quantity.rfind('_') : expected.quantity.find('_');
  figure.figure = expected.quantity.substr(0, unit_at);
  figure.figure.append(" ").append(expected.of);
  figure.unit = expected.quantity.substr(unit_at + 1);
  if (expected.time_s) {
    std::ostringstream text;
    text << " at " << *expected.time_s << " s";
    figure.figure += text.str();
  }
  figure.target = expected.target;
  figure.result = result;
  figure.error = (result - expected.target) / (figure.unit == "degC" ? span_K : std::abs(expected.target));
  figure.tolerance = expected.tolerance;
  figure.passed = std::abs(figure.error) <= figure.tolerance;
  figure.source = expected.source;
  return figure;
}

/// What flows in against what flows out.
CheckedFigure check_balance(const AffineModel& model, const Instant& instant) {
  const HeatBalance balance = steady_heat_balance(model, instant.values, instant.temperatures_K);
  CheckedFigure figure;
  figure.figure = std::string("heat balance");
  figure.unit = std::string("W");
  figure.target = balance.heat_in_W;
  figure.result = balance.heat_out_W;
  figure.error = balance.heat_through_W > 0.0 ? (figure.result - figure.target) / balance.heat_through_W : 0.0;
  figure.tolerance = largest_imbalance;
  figure.passed = std::abs(figure.error) <= figure.tolerance;
  figure.source = std::string("heat in is heat out; the error is a fraction of the heat that passes");
  return figure;
}

}  // namespace

std::string default_cases_directory() { return SPINDLE_TWIN_VERIFY_CASES; }

std::vector<std::string> case_files(const std::string& directory) {
  std::vector<std::string> files;
  std::error_code failure;
  for (const auto& entry : std::filesystem::directory_iterator(directory, failure)) {
    if (entry.path().extension() == ".toml") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) throw rom::InputError({directory, 0}, "--cases", "is no folder that holds descriptions (*.toml)");
  return files;
}

CaseResult run_case(const std::string& path, double mesh_factor, int halvings) {
  Spindle spindle = read_spindle(path, mesh_factor);
  spindle.mesh.halvings = halvings;
  if (!spindle.verification || spindle.verification->expectations.empty()) {
    throw rom::InputError({path, 0}, "verification", "a case needs [verification] and at least one [[expect]]");
  }
  const Verification& verification = *spindle.verification;
  const FeModel fe(spindle, build_section(spindle));
  const AffineModel& model = fe.affine();

  const std::map<double, Instant> instants = along_schedule(model, verification);
  std::optional<Instant> in_steady_state;
  CaseResult result{spindle.name, verification.proves, model.places.size(), {}};
  for (const Expectation& expected : verification.expectations) {
    if (!expected.time_s && !in_steady_state) in_steady_state = steady(model);
    const Instant& instant = expected.time_s ? instants.at(*expected.time_s) : *in_steady_state;
    result.figures.push_back(check(expected, figure_of(fe, instant, expected), verification.temperature_span_K));
  }
  if (in_steady_state && !model.imposed_rises_K) result.figures.push_back(check_balance(model, *in_steady_state));
  return result;
}

}  // namespace spindle_twin::fem_offline

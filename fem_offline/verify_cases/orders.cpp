#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "fem_offline/solve/thermal_system.hpp"
#include "fem_offline/sparse/cholesky.hpp"
#include "fem_offline/verify_cases/fem_case.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double least_value_order = 2.8;
constexpr double least_gradient_order = 1.9;
constexpr double least_stress_order = 2.5;

// I₀(κr) cos(κz) solves Laplace's equation in a body of revolution; κ gives it about one wave over the part.
constexpr double wave_number_per_m = 60.0;

constexpr double ring_rise_K = 10.0;

// Factors of the element sizes. The first mesh may be too coarse to show an order; over the other three, a factor of
// four, the irregularities of free meshes even out.
constexpr std::array<double, 4> mesh_factors = {8.0, 4.0, 2.0, 1.0};

ExactField harmonic() {
  const auto value = [](const Point& at) {
    return std::cyl_bessel_i(0.0, wave_number_per_m * at.r_m) * std::cos(wave_number_per_m * at.z_m);
  };
  const auto gradient = [](const Point& at) {
    const double kr = wave_number_per_m * at.r_m, kz = wave_number_per_m * at.z_m;
    return std::array<double, 2>{wave_number_per_m * std::cyl_bessel_i(1.0, kr) * std::cos(kz),
                                 -wave_number_per_m * std::cyl_bessel_i(0.0, kr) * std::sin(kz)};
  };
  return {value, gradient};
}

/// The steady field when every prescribed temperature takes the exact field's values along its faces:
/// (K₀ + Σ gⱼ Kⱼ) T = Σ gⱼ Kⱼ T_exact.
Eigen::VectorXd solved_with_boundary(const AffineModel& model, const ExactField& exact) {
  const auto count = static_cast<Eigen::Index>(model.places.size());
  Eigen::VectorXd wanted(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const DofPlace& place = model.places[static_cast<std::size_t>(i)];
    wanted[i] = exact.value({place.r_m, place.z_m});
  }
  rom::BoundaryValues values = rom::make_boundary_values(model.boundaries);
  rom::evaluate_boundaries(model.boundaries, model.boundaries.operating, rom::no_correction(model.boundaries), values);
  ThermalSystem system(model);
  system.set_conductances(values.conductance_W_per_m2K);
  Eigen::VectorXd load = Eigen::VectorXd::Zero(count);
  for (std::size_t j = 0; j < model.conductance_terms_m2.size(); ++j) {
    load += values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * (model.conductance_terms_m2[j] * wanted);
  }
  CholeskyFactor factor(system.conduction_lower());
  Eigen::VectorXd solution;
  factor.solve(load, solution);
  return solution;
}

/// Radial displacement of a ring between a and b, its ends held along z, for the rise ΔT ln(b/r)/ln(b/a) (Timoshenko
/// and Goodier, Theory of Elasticity, thermal stress in a long cylinder, ε_z = 0):
///   u = (1 + ν)/(1 − ν) α/r [∫_a^r T r dr + ((1 − 2ν) r² + a²)/(b² − a²) ∫_a^b T r dr]
ExactField ring_displacement(const Spindle& spindle) {
  const Box ring = spindle.supports[0].face;
  const double a_m = ring.r0_m, b_m = ring.r1_m;
  const Material& material = spindle.materials[spindle.parts[0].material];
  const auto integral = [=](double r_m) {
    const double slope = ring_rise_K / std::log(b_m / a_m);
    return 0.5 * slope *
           (r_m * r_m * std::log(b_m / r_m) - a_m * a_m * std::log(b_m / a_m) + 0.5 * (r_m * r_m - a_m * a_m));
  };
  const double nu = material.poisson_ratio;
  const double factor = (1.0 + nu) / (1.0 - nu) * material.expansion_per_K;
  const auto value = [=](const Point& at) {
    const double r2 = at.r_m * at.r_m, share = ((1.0 - 2.0 * nu) * r2 + a_m * a_m) / (b_m * b_m - a_m * a_m);
    return factor / at.r_m * (integral(at.r_m) + share * integral(b_m));
  };
  const auto gradient = [=](const Point& at) {
    const double r2 = at.r_m * at.r_m;
    const double rise_K = ring_rise_K * std::log(b_m / at.r_m) / std::log(b_m / a_m);
    const double share_slope = ((1.0 - 2.0 * nu) - a_m * a_m / r2) / (b_m * b_m - a_m * a_m);
    return std::array<double, 2>{factor * (rise_K - integral(at.r_m) / r2 + share_slope * integral(b_m)), 0.0};
  };
  return {value, gradient};
}

FieldError displacement_error(const FeModel& fe, const Spindle& spindle) {
  const AffineModel& model = fe.affine();
  const Eigen::VectorXd temperatures_K = model.imposed_rises_K->array() + model.boundaries.reference_temperature_K;
  const Eigen::VectorXd moved_m = fe.displacements_m(temperatures_K);
  const Eigen::VectorXd radial_m = moved_m(Eigen::seq(0, moved_m.size() - 1, 2));
  return fe.error_against(ring_displacement(spindle), radial_m);
}

/// Relative error in L2 of the hoop stress λ tr ε + 2μ u/r − (3λ + 2μ) α ΔT, of which the ring's is the largest.
double stress_error(const FeModel& fe, const Spindle& spindle) {
  const AffineModel& model = fe.affine();
  const ExactField moved = ring_displacement(spindle);
  const Box ring = spindle.supports[0].face;
  const Material& material = spindle.materials[spindle.parts[0].material];
  const double nu = material.poisson_ratio, mu_Pa = 0.5 * material.youngs_modulus_Pa / (1.0 + nu);
  const double lambda_Pa = 2.0 * mu_Pa * nu / (1.0 - 2.0 * nu);
  const auto hoop_Pa = [=](const Point& at) {
    const double hoop = moved.value(at) / at.r_m, radial = moved.gradient(at)[0];
    const double rise_K = ring_rise_K * std::log(ring.r1_m / at.r_m) / std::log(ring.r1_m / ring.r0_m);
    return lambda_Pa * (hoop + radial) + 2.0 * mu_Pa * hoop -
           (3.0 * lambda_Pa + 2.0 * mu_Pa) * material.expansion_per_K * rise_K;
  };
  const Eigen::VectorXd temperatures_K = model.imposed_rises_K->array() + model.boundaries.reference_temperature_K;
  const auto no_gradient = [](const Point&) { return std::array<double, 2>{0.0, 0.0}; };
  return fe.error_against({hoop_Pa, no_gradient}, fe.stresses_Pa(temperatures_K).col(2)).value;
}

struct Measured {
  double element_size;  // mean side, but for a factor: one over the root of the number of elements
  FieldError error;
  double stress_error = 0.0;  // of an elastic case
};

double order_between(const Measured& coarse, const Measured& fine, double coarse_error, double fine_error) {
  return std::log(coarse_error / fine_error) / std::log(coarse.element_size / fine.element_size);
}

CheckedFigure order_figure(const std::string& figure, double order, double least) {
  CheckedFigure checked;
  checked.figure = figure;
  checked.unit = "order";
  checked.target = least;
  checked.result = order;
  checked.error = std::max(0.0, least - order);
  checked.passed = order >= least;
  checked.source = "at least; quadratic elements are of order 3 and 2";
  return checked;
}

}  // namespace

std::vector<CaseResult> run_orders(const std::string& directory) {
  std::vector<CaseResult> results;
  const std::string folder = directory + "/orders";
  if (!std::filesystem::is_directory(folder)) return results;
  for (const std::string& path : case_files(folder)) {
    CaseResult result{{}, "observed order of convergence", 0, {}};
    bool elastic = false;
    std::vector<Measured> measured;
    for (const double factor : mesh_factors) {
      const Spindle spindle = read_spindle(path, factor);
      result.id = spindle.name;
      // An imposed temperature is the ring's; all else carries the harmonic field.
      elastic = spindle.imposed_temperature.has_value();
      const FeModel fe(spindle, build_section(spindle));
      const ExactField exact = harmonic();
      measured.push_back({1.0 / std::sqrt(static_cast<double>(fe.element_count())),
                          elastic ? displacement_error(fe, spindle)
                                  : fe.error_against(exact, solved_with_boundary(fe.affine(), exact)),
                          elastic ? stress_error(fe, spindle) : 0.0});
      result.unknowns = fe.affine().places.size();
    }
    const Measured &coarse = measured[1], &fine = measured.back();
    result.figures.push_back(order_figure(elastic ? "displacement in L2" : "temperature in L2",
                                          order_between(coarse, fine, coarse.error.value, fine.error.value),
                                          least_value_order));
    result.figures.push_back(order_figure(elastic ? "strain in L2" : "flux in L2",
                                          order_between(coarse, fine, coarse.error.gradient, fine.error.gradient),
                                          least_gradient_order));
    if (elastic) {
      result.figures.push_back(order_figure(
          "stress in L2", order_between(coarse, fine, coarse.stress_error, fine.stress_error), least_stress_order));
    }
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace spindle_twin::fem_offline

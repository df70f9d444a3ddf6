#include "correction/calibrate/several_starts.hpp"

#include <algorithm>
#include <future>
#include <optional>
#include <random>
#include <thread>
#include <utility>

#include "correction/calibrate/unknowns.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double same_apart = 0.5, other_apart = 1.0;  // deviations
constexpr double similar_cost = 3.0;

/// Farthest parameter of the machine between two fits, in deviations of the second.
double apart(const TestFit& one, const TestFit& other, const TestUnknowns& unknowns) {
  const auto machine = static_cast<Eigen::Index>(unknowns.machine().size());
  const Eigen::ArrayXd deviations = other.covariance.diagonal().head(machine).array().sqrt();
  return ((one.z - other.z).head(machine).array().abs() / deviations).maxCoeff();
}

/// Machines of the prior, on both sides of its mean by turns; all else as the fit has it.
std::vector<Eigen::VectorXd> draws(const FitTask& task, const TestUnknowns& unknowns, const TestFit& fit) {
  std::mt19937_64 random(task.options.start_seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto machine = static_cast<Eigen::Index>(unknowns.machine().size());
  std::vector<Eigen::VectorXd> points;
  Eigen::VectorXd step(machine);
  for (int k = 1; k < task.options.starts; ++k) {
    if (k % 2 == 1) {
      for (double& each : step) each = normal(random);
    } else {
      step = -step;
    }
    points.push_back(fit.z);
    points.back().head(machine) =
        unknowns.mean().head(machine) + unknowns.root().topLeftCorner(machine, machine) * step;
    for (Eigen::Index i = 0; i < machine; ++i) {
      const Eigen::Index slot = unknowns.machine()[static_cast<std::size_t>(i)];
      const Parameter& parameter = task.predictor.parameters().list()[static_cast<std::size_t>(slot)];
      points.back()[i] = std::clamp(points.back()[i], parameter.minimum, parameter.maximum);
    }
  }
  return points;
}

/// Nothing where the model cannot be integrated from there.
std::optional<TestFit> fit_from(const FitTask& task, const TestUnknowns& unknowns, const TestFit& first,
                                const Eigen::VectorXd& point) {
  try {
    TestFit found = fit_tests_once(task, point, first.weights);
    if (apart(found, first, unknowns) <= same_apart) return found;
    const int evaluations = found.evaluations;
    found = fit_tests(task, &found.z, {});
    found.evaluations += evaluations;
    return found;
  } catch (const rom::InputError&) {
    return std::nullopt;
  }
}

/// The other minima into the covariance of the best.
void widen(const std::vector<TestFit>& fits, const TestUnknowns& unknowns, std::size_t best, SeveralStarts& result) {
  std::vector<const TestFit*> others;
  for (std::size_t k = 0; k < fits.size(); ++k) {
    StartedFit& start = result.starts[k];
    start.cost = fits[k].cost - fits[best].cost;
    start.apart = apart(fits[k], fits[best], unknowns);
    start.is_other = k != best && start.apart > other_apart && start.cost < similar_cost;
    const bool is_known = std::any_of(others.begin(), others.end(), [&](const TestFit* other) {
      return apart(fits[k], *other, unknowns) <= other_apart;
    });
    if (start.is_other && !is_known) others.push_back(&fits[k]);
  }
  for (const TestFit* other : others) {
    const Eigen::VectorXd between = other->z - result.fit.z;
    result.fit.covariance += 0.25 * between * between.transpose();
  }
}

}  // namespace

SeveralStarts fit_from_several(const FitTask& task, const Eigen::VectorXd& first,
                               const std::function<void(int)>& progress) {
  const TestUnknowns unknowns(task.network, task.predictor.parameters(), task.options, task.tests);
  std::vector<TestFit> fits{fit_tests(task, &first, progress)};
  const std::vector<Eigen::VectorXd> points = draws(task, unknowns, fits.front());
  int evaluations = fits.front().evaluations;
  const std::size_t at_once = std::max(1u, std::thread::hardware_concurrency());
  const TestFit from = fits.front();
  for (std::size_t begin = 0; begin < points.size(); begin += at_once) {
    const std::size_t end = std::min(points.size(), begin + at_once);
    std::vector<std::future<std::optional<TestFit>>> running;
    for (std::size_t k = begin; k < end; ++k) {
      running.push_back(std::async(std::launch::async, [&, k] { return fit_from(task, unknowns, from, points[k]); }));
    }
    for (auto& each : running) {
      std::optional<TestFit> found = each.get();
      if (!found) continue;
      evaluations += found->evaluations;
      if (progress) progress(evaluations);
      fits.push_back(std::move(*found));
    }
  }
  std::size_t best = 0;
  for (std::size_t k = 1; k < fits.size(); ++k) {
    // The same place from another side is no better one.
    if (fits[k].cost < fits[best].cost && apart(fits[k], fits[0], unknowns) > same_apart) best = k;
  }
  SeveralStarts result;
  result.fit = fits[best];
  for (const TestFit& fit : fits) result.starts.push_back({0.0, 0.0, fit.evaluations, false});
  widen(fits, unknowns, best, result);
  result.fit.evaluations = evaluations;
  return result;
}

}  // namespace spindle_twin::correction

#include "correction/calibrate/asked_heat.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "correction/estimator/operating_heat.hpp"

namespace spindle_twin::correction {
namespace {

/// The same priors with a heat in each group; how wide it is plays no part.
CalibrateOptions with_heats(CalibrateOptions options) {
  constexpr double any_share = 0.01;
  options.priors.disturbance = options.priors.disturbance_by_hand = any_share;
  return options;
}

}  // namespace

double AskedHeat::deviations() const { return std::abs(heat_W) / deviation_W; }

HeatResponses heat_responses(const FitTask& task, const TestFit& fit) {
  const TestUnknowns unknowns(task.network, task.predictor.parameters(), task.options, task.tests);
  const CalibrateOptions options = with_heats(task.options);
  const TestPredictor predictor(task.network, options);
  const ParameterModel& parameters = predictor.parameters();
  HeatResponses responses;
  if (!parameters.has_disturbances()) return responses;
  for (const auto& group : parameters.groups()) responses.groups.push_back(group.name);
  for (std::size_t test = 0; test < task.tests.size(); ++test) {
    const Eigen::VectorXd theta = task.predictor.parameters().as_in(parameters, unknowns.theta(fit.z, test));
    const TestPrediction at = predictor.predict(task.tests[test], theta, unknowns.lag_s(fit.z));
    responses.of_test.emplace_back(at.sensitivities.middleCols(parameters.disturbance(0), parameters.group_count()));
  }
  return responses;
}

std::vector<AskedHeat> heats_asked_for(const FitTask& task, const TestFit& fit) {
  const TestUnknowns unknowns(task.network, task.predictor.parameters(), task.options, task.tests);
  const HeatResponses responses = heat_responses(task, fit);
  const auto groups = static_cast<Eigen::Index>(responses.groups.size());
  if (groups == 0) return {};
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(groups, groups);
  Eigen::MatrixXd shared = Eigen::MatrixXd::Zero(unknowns.count(), groups);
  Eigen::MatrixXd known_too = Eigen::MatrixXd::Identity(unknowns.count(), unknowns.count());  // I + L₀ᵀ Jᵀ W⁻¹ J L₀
  Eigen::VectorXd score = Eigen::VectorXd::Zero(groups);
  for (std::size_t test = 0; test < task.tests.size(); ++test) {
    const Eigen::LLT<Eigen::MatrixXd> weight(fit.weights[test]);
    const Eigen::MatrixXd rows = weight.matrixL().solve(responses.of_test[test]);
    const Eigen::MatrixXd known = weight.matrixL().solve(unknowns.rows(fit.readings[test], test) * unknowns.root());
    known_too.noalias() += known.transpose() * known;
    own.noalias() += rows.transpose() * rows;
    shared.noalias() += known.transpose() * rows;
    score.noalias() += rows.transpose() * weight.matrixL().solve(fit.left[test]);
  }
  const Eigen::MatrixXd explained = Eigen::LLT<Eigen::MatrixXd>(known_too).matrixL().solve(shared);
  const Eigen::MatrixXd information = own - explained.transpose() * explained;
  const double most_W = nominal_heats_W(task.network);
  std::vector<AskedHeat> asked;
  for (Eigen::Index g = 0; g < groups; ++g) {
    const double heat_W = score[g] / information(g, g);
    if (!(std::abs(heat_W) <= most_W)) continue;
    asked.push_back({responses.groups[static_cast<std::size_t>(g)], heat_W, 1.0 / std::sqrt(information(g, g))});
  }
  std::stable_sort(asked.begin(), asked.end(),
                   [](const AskedHeat& a, const AskedHeat& b) { return a.deviations() > b.deviations(); });
  return asked;
}

}  // namespace spindle_twin::correction

#include "correction/calibrate/hold_out.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "correction/calibrate/residual_covariance.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double the_end_itself = 1e-9;  // share of a test: a reading at the end of the first part was seen

/// One test: its readings before and after the end of what was seen, and how the latter follow from the former.
struct Foreseen {
  std::vector<Eigen::Index> seen, held;
  Eigen::LLT<Eigen::MatrixXd> weight;  // of W_ss
  Eigen::MatrixXd carried;             // B
  Eigen::MatrixXd seen_rows, rows;     // J_s, Z
  Eigen::VectorXd left;                // r
  Eigen::MatrixXd noise;               // W_hh − B W_sh
};

Foreseen foresee(const FitTask& task, const TestFit& at, std::size_t test, double before_share) {
  Foreseen result;
  const double from_s = task.tests[test].time_s.front() + (before_share + the_end_itself) * task.tests[test].length_s();
  for (Eigen::Index r = 0; r < at.left[test].size(); ++r) {
    const bool is_seen = at.readings[test].readings[static_cast<std::size_t>(r)].time_s < from_s;
    (is_seen ? result.seen : result.held).push_back(r);
  }
  Eigen::MatrixXd all = residual_covariance(at.readings[test], task.predictor.parameters(), task.options,
                                            start_spread_K(task.tests[test], task.options));
  for (const Eigen::Index r : result.seen) all(r, r) = at.weights[test](r, r);  // outliers say less
  const Eigen::MatrixXd mixed = all(result.seen, result.held);
  result.weight.compute(all(result.seen, result.seen));
  result.carried = result.weight.solve(mixed).transpose();
  result.noise = all(result.held, result.held) - result.carried * mixed;
  const TestUnknowns unknowns(task.network, task.predictor.parameters(), task.options, task.tests);
  const Eigen::MatrixXd rows = unknowns.rows(at.readings[test], test);
  result.seen_rows = rows(result.seen, Eigen::all);
  result.rows = rows(result.held, Eigen::all) - result.carried * result.seen_rows;
  result.left = at.left[test](result.held) - result.carried * at.left[test](result.seen);
  return result;
}

HeldOutMean mean_of(const FitTask& task, const TestFit& at, const Foreseen& foreseen, const ChannelFit& channel) {
  Eigen::VectorXd share = Eigen::VectorXd::Zero(foreseen.left.size());
  const auto count = static_cast<double>(channel.readings);
  double rise = 0.0;
  for (std::size_t h = 0; h < foreseen.held.size(); ++h) {
    const TestReading& reading = at.readings[channel.test].readings[static_cast<std::size_t>(foreseen.held[h])];
    if (reading.channel != channel.channel) continue;
    share[static_cast<Eigen::Index>(h)] = 1.0 / count;
    rise += reading.rise / count;
  }
  const Eigen::VectorXd along = foreseen.rows.transpose() * share;
  double variance = share.dot(foreseen.noise * share) + along.dot(at.covariance * along);
  if (channel.channel < static_cast<int>(task.options.sensors.size())) {
    variance += std::pow(task.options.sensor_error_K, 2) + std::pow(task.options.sensor_error_share * rise, 2);
  }
  return {share.dot(foreseen.left), std::sqrt(variance)};
}

/// What all held-out readings say of the heat of one column of `responses`.
AskedHeat heat_after(const TestFit& at, const std::vector<Foreseen>& tests, const HeatResponses& responses,
                     Eigen::Index group) {
  Eigen::VectorXd bent = Eigen::VectorXd::Zero(at.covariance.rows());  // Σ J_sᵀ W_ss⁻¹ a_s
  Eigen::Index count = 0;
  for (std::size_t test = 0; test < tests.size(); ++test) {
    const Eigen::VectorXd response = responses.of_test[test].col(group)(tests[test].seen);
    bent.noalias() += tests[test].seen_rows.transpose() * tests[test].weight.solve(response);
    count += tests[test].left.size();
  }
  bent = (at.covariance * bent).eval();
  Eigen::MatrixXd rows(count, at.covariance.rows()), covariance = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd response(count), left(count);
  Eigen::Index first = 0;
  for (std::size_t test = 0; test < tests.size(); ++test) {
    const Foreseen& one = tests[test];
    const Eigen::Index some = one.left.size();
    const auto column = responses.of_test[test].col(group);
    rows.middleRows(first, some) = one.rows;
    covariance.block(first, first, some, some) = one.noise;
    left.segment(first, some) = one.left;
    response.segment(first, some) = column(one.held) - one.carried * column(one.seen) - one.rows * bent;
    first += some;
  }
  covariance.noalias() += rows * at.covariance * rows.transpose();
  const Eigen::VectorXd weighed = Eigen::LLT<Eigen::MatrixXd>(covariance).solve(response);
  const double information = weighed.dot(response);
  return {responses.groups[static_cast<std::size_t>(group)], weighed.dot(left) / information,
          1.0 / std::sqrt(information)};
}

}  // namespace

HoldOut hold_out(const FitTask& task, const TestFit& seen, double before_share) {
  const TestFit at = judge_tests(task, seen.z, seen.covariance);
  HoldOut result;
  result.channels = channels_from(task, at, before_share + the_end_itself);
  std::vector<Foreseen> tests;
  for (std::size_t test = 0; test < task.tests.size(); ++test) tests.push_back(foresee(task, at, test, before_share));
  for (ChannelFit& channel : result.channels) channel.held_out = mean_of(task, at, tests[channel.test], channel);
  if (result.channels.empty()) return result;

  std::vector<ThermalTest> first_parts;
  for (const ThermalTest& test : task.tests) first_parts.push_back(first_part(test, before_share));
  const std::vector<AskedHeat> asked = heats_asked_for({task.network, task.predictor, task.options, first_parts}, seen);
  if (asked.empty()) return result;
  const HeatResponses responses = heat_responses(task, at);
  for (std::size_t group = 0; group < responses.groups.size(); ++group) {
    if (responses.groups[group] != asked.front().group) continue;
    result.heat = HeldOutHeat{asked.front(), heat_after(at, tests, responses, static_cast<Eigen::Index>(group))};
  }
  return result;
}

}  // namespace spindle_twin::correction

#include "correction/calibrate/fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <future>
#include <unsupported/Eigen/NonLinearOptimization>
#include <utility>

#include "correction/calibrate/residual_covariance.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::correction {
namespace {

constexpr int refreshes = 3;              // of W
constexpr double largest_step = 3.0;      // of the first one, in deviations of the prior
constexpr double step_tolerance = 1e-4;   // of u
constexpr double value_tolerance = 1e-5;  // of the sum of squares
constexpr int most_evaluations = 40;      // with one W
constexpr double outlier = 3.0;           // deviations, from which a reading pulls the less the further it is off

struct Evaluated {
  std::vector<TestPrediction> predictions;
  std::vector<Eigen::VectorXd> left;
  std::vector<Eigen::MatrixXd> rows;
};

/// All tests with one z.
class Evaluator {
 public:
  Evaluator(const FitTask& task, const TestUnknowns& unknowns, std::function<void(int)> progress)
      : predictor_(task.predictor), unknowns_(unknowns), tests_(task.tests), progress_(std::move(progress)) {}

  Evaluated operator()(const Eigen::VectorXd& z) {
    const Eigen::VectorXd lag_s = unknowns_.lag_s(z);
    std::vector<std::future<TestPrediction>> running;
    const auto one = [&](std::size_t test) {
      return predictor_.predict(tests_[test], unknowns_.theta(z, test), lag_s);
    };
    for (std::size_t test = 1; test < tests_.size(); ++test) {
      running.push_back(std::async(std::launch::async, one, test));
    }
    Evaluated result;
    result.predictions.push_back(one(0));
    for (auto& each : running) result.predictions.push_back(each.get());
    for (std::size_t test = 0; test < tests_.size(); ++test) {
      const std::vector<TestReading>& readings = result.predictions[test].readings;
      Eigen::VectorXd left(static_cast<Eigen::Index>(readings.size()));
      for (std::size_t r = 0; r < readings.size(); ++r) {
        left[static_cast<Eigen::Index>(r)] = readings[r].residual - unknowns_.offset(z, test, readings[r].channel);
      }
      if (readings.empty()) throw rom::InputError({tests_[test].name, 0}, "", "has no reading of any channel");
      result.left.push_back(left);
      result.rows.push_back(unknowns_.rows(result.predictions[test], test));
    }
    ++count_;
    if (progress_) progress_(count_);
    return result;
  }

  int count() const { return count_; }

 private:
  const TestPredictor& predictor_;
  const TestUnknowns& unknowns_;
  const std::vector<ThermalTest>& tests_;
  std::function<void(int)> progress_;
  int count_ = 0;
};

/// The least squares in u as Eigen's solver asks for them; the last evaluation serves values and derivatives alike.
class WhitenedProblem {
 public:
  using Scalar = double;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;

  WhitenedProblem(Evaluator& evaluate, const TestUnknowns& unknowns, std::vector<Eigen::LLT<Eigen::MatrixXd>> weights)
      : evaluate_(evaluate), unknowns_(unknowns), weights_(std::move(weights)) {
    for (const auto& weight : weights_) readings_ += weight.rows();
  }

  int inputs() const { return static_cast<int>(unknowns_.count()); }
  int values() const { return static_cast<int>(readings_ + unknowns_.count()); }

  int operator()(const Eigen::VectorXd& u, Eigen::VectorXd& value) {
    at(u);
    value.resize(values());
    Eigen::Index row = 0;
    for (std::size_t test = 0; test < weights_.size(); ++test) {
      value.segment(row, weights_[test].rows()) = weights_[test].matrixL().solve(last_.left[test]);
      row += weights_[test].rows();
    }
    value.tail(u.size()) = u;
    return 0;
  }

  int df(const Eigen::VectorXd& u, Eigen::MatrixXd& jacobian) {
    at(u);
    jacobian.resize(values(), inputs());
    Eigen::Index row = 0;
    for (std::size_t test = 0; test < weights_.size(); ++test) {
      const Eigen::MatrixXd in_u = -last_.rows[test] * unknowns_.root();
      jacobian.middleRows(row, weights_[test].rows()) = weights_[test].matrixL().solve(in_u);
      row += weights_[test].rows();
    }
    jacobian.bottomRows(inputs()).setIdentity();
    return 0;
  }

 private:
  void at(const Eigen::VectorXd& u) {
    if (seen_.size() == u.size() && seen_ == u) return;
    last_ = evaluate_(unknowns_.mean() + unknowns_.root() * u);
    seen_ = u;
  }

  Evaluator& evaluate_;
  const TestUnknowns& unknowns_;
  std::vector<Eigen::LLT<Eigen::MatrixXd>> weights_;
  Eigen::Index readings_ = 0;
  Eigen::VectorXd seen_;
  Evaluated last_;
};

/// W of each test, wider where what is left of a reading is an outlier.
std::vector<Eigen::MatrixXd> covariances(const Evaluated& at, const FitTask& task, bool robust) {
  std::vector<Eigen::MatrixXd> result;
  for (std::size_t test = 0; test < at.predictions.size(); ++test) {
    result.push_back(residual_covariance(at.predictions[test], task.predictor.parameters(), task.options,
                                         start_spread_K(task.tests[test], task.options)));
    for (Eigen::Index r = 0; robust && r < at.left[test].size(); ++r) {
      const double variance = result.back()(r, r);
      const double off = std::abs(at.left[test][r]) / std::sqrt(variance);
      if (off > outlier) result.back()(r, r) += variance * (off / outlier - 1.0) * off;
    }
  }
  return result;
}

ChannelFit describe(const FitTask& task, const TestFit& fit, std::size_t test, int channel, double from_s) {
  const int sensors = static_cast<int>(task.options.sensors.size());
  ChannelFit result;
  result.name = channel < sensors ? task.options.sensors[static_cast<std::size_t>(channel)].name
                                  : task.network.deformations[static_cast<std::size_t>(channel - sensors)].name;
  result.test = test;
  result.channel = channel;
  double squares = 0.0, expected = 0.0, products = 0.0, before = 0.0;
  for (std::size_t r = 0; r < fit.readings[test].readings.size(); ++r) {
    const TestReading& reading = fit.readings[test].readings[r];
    if (reading.channel != channel || reading.time_s < from_s) continue;
    const auto row = static_cast<Eigen::Index>(r);
    const double left = fit.left[test][row];
    squares += left * left;
    expected += fit.expected[test](row, row);
    if (result.readings > 0) products += left * before;
    before = left;
    ++result.readings;
    if (left * left > outlier * outlier * fit.expected[test](row, row)) ++result.outliers;
  }
  if (result.readings == 0) return result;
  result.rms = std::sqrt(squares / static_cast<double>(result.readings));
  result.expected_rms = std::sqrt(expected / static_cast<double>(result.readings));
  result.lag_1 = squares > 0.0 ? products / squares : 0.0;
  return result;
}

TestFit finish(const FitTask& task, Evaluated at, const Eigen::VectorXd& z, const Eigen::MatrixXd& covariance) {
  TestFit fit;
  fit.z = z;
  fit.covariance = covariance;
  const std::vector<Eigen::MatrixXd> weights = covariances(at, task, false);
  double squares = 0.0, count = 0.0;
  for (std::size_t test = 0; test < at.left.size(); ++test) {
    squares += Eigen::LLT<Eigen::MatrixXd>(weights[test]).matrixL().solve(at.left[test]).squaredNorm();
    count += static_cast<double>(at.left[test].size());
    fit.expected.push_back(weights[test] + at.rows[test] * covariance * at.rows[test].transpose());
  }
  fit.chi_square_per_reading = squares / count;
  fit.weights = covariances(at, task, true);
  for (std::size_t test = 0; test < at.left.size(); ++test) {
    const Eigen::LLT<Eigen::MatrixXd> root(fit.weights[test]);
    fit.cost += 0.5 * root.matrixL().solve(at.left[test]).squaredNorm();
    fit.cost += root.matrixLLT().diagonal().array().log().sum();
  }
  fit.readings = std::move(at.predictions);
  fit.left = std::move(at.left);
  fit.channels = channels_from(task, fit, 0.0);
  return fit;
}

Eigen::VectorXd in_deviations(const TestUnknowns& unknowns, const Eigen::VectorXd& z) {
  return unknowns.root().triangularView<Eigen::Lower>().solve(z - unknowns.mean());
}

/// u goes to the minimum with this W; its covariance there, of z.
Eigen::MatrixXd minimise(Evaluator& evaluate, const TestUnknowns& unknowns, const std::vector<Eigen::MatrixXd>& weights,
                         Eigen::VectorXd& u) {
  std::vector<Eigen::LLT<Eigen::MatrixXd>> roots;
  roots.reserve(weights.size());
  for (const Eigen::MatrixXd& each : weights) roots.emplace_back(each);
  WhitenedProblem problem(evaluate, unknowns, std::move(roots));
  Eigen::LevenbergMarquardt<WhitenedProblem> solver(problem);
  solver.parameters.factor = largest_step;
  solver.parameters.ftol = value_tolerance;
  solver.parameters.xtol = step_tolerance;
  solver.parameters.maxfev = most_evaluations;
  solver.minimize(u);
  Eigen::MatrixXd jacobian;
  problem.df(u, jacobian);
  const Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  const Eigen::MatrixXd half =
      Eigen::LLT<Eigen::MatrixXd>(information).matrixL().solve(unknowns.root().transpose()).eval();
  return half.transpose() * half;
}

TestFit finished(const FitTask& task, const TestUnknowns& unknowns, Evaluator& evaluate, const Eigen::VectorXd& u,
                 const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd z = unknowns.mean() + unknowns.root() * u;
  TestFit fit = finish(task, evaluate(z), z, covariance);
  fit.cost += 0.5 * u.squaredNorm();
  fit.evaluations = evaluate.count();
  return fit;
}

}  // namespace

std::vector<ChannelFit> channels_from(const FitTask& task, const TestFit& fit, double share) {
  std::vector<ChannelFit> channels;
  const int count = static_cast<int>(task.options.sensors.size() + task.network.deformations.size());
  for (std::size_t test = 0; test < task.tests.size(); ++test) {
    const double from_s = task.tests[test].time_s.front() + share * task.tests[test].length_s();
    for (int channel = 0; channel < count; ++channel) {
      const ChannelFit described = describe(task, fit, test, channel, from_s);
      if (described.readings > 0) channels.push_back(described);
    }
  }
  return channels;
}

TestFit fit_tests(const FitTask& task, const Eigen::VectorXd* start, const std::function<void(int)>& progress) {
  const TestUnknowns unknowns(task.network, task.predictor.parameters(), task.options, task.tests);
  Evaluator evaluate(task, unknowns, progress);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(unknowns.count());
  if (start != nullptr) u = in_deviations(unknowns, *start);
  Eigen::MatrixXd covariance;
  for (int refresh = 0; refresh < refreshes; ++refresh) {
    const Evaluated at = evaluate(unknowns.mean() + unknowns.root() * u);
    covariance = minimise(evaluate, unknowns, covariances(at, task, refresh > 0), u);
  }
  return finished(task, unknowns, evaluate, u, covariance);
}

TestFit fit_tests_once(const FitTask& task, const Eigen::VectorXd& start, const std::vector<Eigen::MatrixXd>& weights) {
  const TestUnknowns unknowns(task.network, task.predictor.parameters(), task.options, task.tests);
  Evaluator evaluate(task, unknowns, {});
  Eigen::VectorXd u = in_deviations(unknowns, start);
  const Eigen::MatrixXd covariance = minimise(evaluate, unknowns, weights, u);
  return finished(task, unknowns, evaluate, u, covariance);
}

TestFit judge_tests(const FitTask& task, const Eigen::VectorXd& z, const Eigen::MatrixXd& covariance) {
  const TestUnknowns unknowns(task.network, task.predictor.parameters(), task.options, task.tests);
  Evaluator evaluate(task, unknowns, {});
  return finish(task, evaluate(z), z, covariance);
}

ThermalTest first_part(const ThermalTest& test, double share) {
  const double until_s = test.time_s.front() + share * test.length_s();
  const auto end = std::upper_bound(test.time_s.begin(), test.time_s.end(), until_s);
  const auto count = std::max<std::ptrdiff_t>(2, end - test.time_s.begin());
  ThermalTest part = test;
  part.time_s.resize(static_cast<std::size_t>(count));
  part.operating.resize(static_cast<std::size_t>(count));
  part.measured_K = test.measured_K.topRows(count).eval();
  part.deformation_m = test.deformation_m.topRows(count).eval();
  return part;
}

}  // namespace spindle_twin::correction

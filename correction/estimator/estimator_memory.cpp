#include <algorithm>
#include <cmath>

#include "correction/estimator/estimator_core.hpp"

namespace spindle_twin::correction {
namespace {

// What a pause may have done unseen: of the rise that it had time for, 1 sigma of how much; what the shape of that rise
// may miss, because heat comes and goes in other ways; and how long both stay open.
constexpr double unseen_share = 0.5;
constexpr double unseen_shape = 0.2;
constexpr double unseen_memory_s = 600.0;

/// Calls visit(numbers, their place in the state) for everything that is remembered.
template <class Visit>
void remembered(const EstimatorCore& core, EstimatorState& state, const Visit& visit) {
  const Eigen::Index p = core.parameters.count();
  visit(core.filter.mean(), state.mean, Eigen::Index{0});
  visit(core.filter.root().reshaped(), state.root, Eigen::Index{0});
  visit(core.sensitivities.transposed().reshaped(), state.sensitivities, Eigen::Index{0});
  for (std::size_t s = 0; s < core.windows.size(); ++s) {
    visit(core.windows[s].lagged_sensitivity, state.lagged, static_cast<Eigen::Index>(s) * p);
  }
}

}  // namespace

void EstimatorCore::save(EstimatorState& state) const {
  const auto n = static_cast<std::size_t>(filter.size());
  state.mean.resize(n);
  state.root.resize(n * n);
  state.sensitivities.resize(static_cast<std::size_t>(sensitivities.transposed().size()));
  state.lagged.resize(windows.size() * static_cast<std::size_t>(parameters.count()));
  remembered(*this, state, [](const auto& numbers, std::vector<double>& to, Eigen::Index at) {
    for (Eigen::Index i = 0; i < numbers.size(); ++i) to[static_cast<std::size_t>(at + i)] = numbers[i];
  });
}

bool EstimatorCore::restore(const EstimatorState& state) {
  const auto n = static_cast<std::size_t>(filter.size());
  const auto p = static_cast<std::size_t>(parameters.count());
  const auto fits = [](const std::vector<double>& numbers, std::size_t count) {
    return numbers.size() == count &&
           std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
  };
  if (!started || !fits(state.mean, n) || !fits(state.root, n * n) || !fits(state.lagged, windows.size() * p) ||
      !fits(state.sensitivities, static_cast<std::size_t>(sensitivities.transposed().size()))) {
    return false;
  }
  const auto size = static_cast<Eigen::Index>(n);
  filter.set_mean(Eigen::Map<const Eigen::VectorXd>(state.mean.data(), size));
  filter.set_root(Eigen::Map<const Eigen::MatrixXd>(state.root.data(), size, size));
  sensitivities.set_transposed(Eigen::Map<const Eigen::MatrixXd>(state.sensitivities.data(),
                                                                 sensitivities.transposed().rows(), shared->nodes()));
  theta = filter.mean().head(parameters.count());
  for (std::size_t s = 0; s < windows.size(); ++s) {
    sensitivities.of_row(windows[s].internal, windows[s].sensitivity);
    windows[s].lagged_sensitivity = Eigen::Map<const Eigen::VectorXd>(state.lagged.data() + s * p, parameters.count());
    const auto b = parameters.count() + static_cast<Eigen::Index>(s);
    windows[s].record.offset_K = filter.mean()[b];
    windows[s].record.offset_deviation_K = filter.deviation(b);
  }
  note_bend();
  outputs.evaluate(sensitivities, filter, bend, nodes_K);
  return true;
}

void EstimatorCore::widen_start(double time_s, const Eigen::VectorXd& nodes, const Eigen::VectorXd& rise_K) {
  const Eigen::Index start = parameters.start();
  if (start < 0) return;
  nodes_K = nodes;
  close_period(time_s);
  const double deviation = parameters.list()[static_cast<std::size_t>(start)].deviation;
  // What was open of the start before adds to it, node by node.
  const Eigen::ArrayXd before_K = filter.deviation(start) * sensitivities.in_kelvin().col(start).array();
  const Eigen::ArrayXd heated_K = unseen_share * rise_K.array();
  sensitivities.set_start((heated_K.square() + before_K.square()).sqrt().matrix() / deviation, parameters);
  keep.setOnes();
  growth.setZero();
  keep[start] = 0.0;
  growth[start] = deviation * deviation;
  filter.pass_time(prior_mean, keep, growth);
  theta = filter.mean().head(parameters.count());
  start_memory_s = unseen_memory_s;
  start_shape = unseen_shape * deviation;
  widened_s = time_s;
  fresh_until_s = time_s + fresh_s;
  for (SensorWindow& window : windows) {
    sensitivities.of_row(window.internal, window.sensitivity);
    window.lagged_sensitivity[start] = window.sensitivity[start];
  }
  note_bend();
  outputs.evaluate(sensitivities, filter, bend, nodes_K);
}

}  // namespace spindle_twin::correction

#include "correction/health/update_without.hpp"

#include <cmath>

#include "correction/health/surprise.hpp"

namespace spindle_twin::correction {

double surprise_of(const EstimatorCorrection& estimator) {
  const EstimatorUpdate& made = estimator.last_update();
  double sum = 0.0;
  for (Eigen::Index s = 0; s < made.innovation_K.size(); ++s) {
    const SensorRecord& record = estimator.record(s);
    if (std::isfinite(made.innovation_K[s])) sum += surprise(record.innovation_K, record.variance_K2);
  }
  if (!std::isfinite(made.displacement_m)) return sum;
  const SensorRecord& record = estimator.displacement_record();
  return sum + surprise(record.innovation_K, record.variance_K2);
}

void note_misfit(const EstimatorCorrection& estimator, Eigen::Index sensor, SquareRootFilter& filter,
                 Eigen::VectorXd& row, Misfit& misfit) {
  const EstimatorUpdate& made = estimator.last_update();
  row = made.rows.col(sensor);
  const double missed_K = made.innovation_at(sensor, filter.mean());
  misfit.judged = std::isfinite(missed_K);
  if (!misfit.judged) return;
  misfit.misfit_K = missed_K;
  misfit.deviation_K = std::sqrt(filter.variance_of(row) + made.noise_K2[sensor]);
}

double update_without(const EstimatorCorrection& estimator, Eigen::Index sensor, SquareRootFilter& filter,
                      Eigen::VectorXd& row) {
  const EstimatorUpdate& made = estimator.last_update();
  const double gate2 = estimator.gate() * estimator.gate();
  double surprised = 0.0;
  const auto judge = [&](double innovation, double noise) {
    const double variance = filter.variance_of(row) + noise;
    surprised += surprise(innovation, variance);
    if (innovation * innovation <= gate2 * variance) filter.update(row, innovation, noise);
  };
  for (Eigen::Index s = 0; s < made.innovation_K.size(); ++s) {
    if (s == sensor || !std::isfinite(made.innovation_K[s])) continue;
    row = made.rows.col(s);
    judge(made.innovation_at(s, filter.mean()), made.noise_K2[s]);
  }
  if (std::isfinite(made.displacement_m)) {
    row = made.displacement_row;
    judge(made.displacement_at(filter.mean()), made.displacement_variance_m2);
  }
  row = filter.mean();
  estimator.bound(row);
  filter.set_mean(row);
  return surprised;
}

}  // namespace spindle_twin::correction

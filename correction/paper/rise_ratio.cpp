#include "correction/paper/rise_ratio.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spindle_twin::correction {
namespace {

double smaller_magnitude(double a, double b) { return std::abs(b) < std::abs(a) ? b : a; }

}  // namespace

RiseRatio rise_ratio(RatioForm form, const Eigen::Ref<const Eigen::VectorXd>& measured_K,
                     const Eigen::Ref<const Eigen::VectorXd>& model_K,
                     const Eigen::Ref<const Eigen::VectorXd>& zero_K) {
  const double count = static_cast<double>(measured_K.size());
  RiseRatio result;
  if (form == RatioForm::consistent) {
    // Ratio of sums, not mean of ratios: the coldest sensor must not dominate.
    result.measured_rise_K = (measured_K - zero_K).sum() / count;
    result.model_rise_K = (model_K - zero_K).sum() / count;
    result.ratio = result.measured_rise_K / result.model_rise_K;
    return result;
  }
  double mean_ratio = 0.0;
  double mean_residual_share = 0.0;  // the paper's r
  result.measured_rise_K = result.model_rise_K = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < measured_K.size(); ++i) {
    const double measured_rise_K = measured_K[i] - zero_K[i];
    const double model_rise_K = model_K[i] - zero_K[i];
    mean_ratio += measured_rise_K / model_rise_K / count;
    mean_residual_share += (measured_rise_K - model_rise_K) / measured_rise_K / count;
    result.measured_rise_K = smaller_magnitude(result.measured_rise_K, measured_rise_K);
    result.model_rise_K = smaller_magnitude(result.model_rise_K, model_rise_K);
  }
  switch (form) {
    case RatioForm::average_ratio:
      result.ratio = 1.0 / (1.0 - mean_residual_share);
      break;
    case RatioForm::as_printed_additive:
      result.ratio = std::max(0.0, 1.0 + mean_residual_share);
      break;
    default:
      result.ratio = mean_ratio;
  }
  return result;
}

}  // namespace spindle_twin::correction

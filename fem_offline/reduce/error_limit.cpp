#include "fem_offline/reduce/error_limit.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/non_central_t.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

namespace spindle_twin::fem_offline {

int limiting_rank(int cases, double content) {
  const boost::math::binomial above(cases, 1.0 - content);
  int rank = 0;
  while (rank < cases && boost::math::cdf(above, rank) <= 1.0 - limit_confidence) ++rank;
  return rank;
}

double error_of_rank(std::vector<double> errors, int rank) {
  const auto wanted = errors.begin() + (rank - 1);
  std::nth_element(errors.begin(), wanted, errors.end(), std::greater<>());
  return *wanted;
}

double normal_limit_factor(int cases) {
  const double root = std::sqrt(static_cast<double>(cases));
  const double content_deviations = boost::math::quantile(boost::math::normal(), limit_content);
  const boost::math::non_central_t ratio(cases - 1, root * content_deviations);
  return boost::math::quantile(ratio, limit_confidence) / root;
}

double error_limit(std::vector<double> errors) {
  const int cases = static_cast<int>(errors.size());
  if (cases < fewest_limiting_cases) return 0.0;
  const double largest = *std::max_element(errors.begin(), errors.end());
  if (largest <= 0.0) return 0.0;
  if (const int rank = limiting_rank(cases); rank > 0) return error_of_rank(std::move(errors), rank);
  constexpr double negligible = 1e-12;  // of the largest: what is smaller is rounding, whose logarithm says nothing
  Eigen::ArrayXd logarithms(cases);
  for (int i = 0; i < cases; ++i) {
    logarithms[i] = std::log(std::max(errors[static_cast<std::size_t>(i)], negligible * largest));
  }
  const double mean = logarithms.mean();
  const double deviation = std::sqrt((logarithms - mean).square().sum() / (cases - 1));
  return std::max(largest, std::exp(mean + normal_limit_factor(cases) * deviation));
}

rom::CertificateLimit limit_rule(int cases) {
  if (cases < fewest_limiting_cases) return {};
  return {limit_content, limit_confidence, limiting_rank(cases) == 0};
}

double LimitCheck::share() const {
  if (cases == 0 || outputs.empty()) return 0.0;
  return std::accumulate(above.begin(), above.end(), 0.0) /
         (static_cast<double>(cases) * static_cast<double>(above.size()));
}

LimitCheck check_limits(const rom::Network& certified, const Eigen::MatrixXd& errors) {
  LimitCheck check;
  check.cases = static_cast<int>(errors.cols());
  Eigen::Index row = 0;
  const auto judge = [&](const auto& items, const std::vector<rom::OutputError>& certificate, const std::string& kind) {
    for (std::size_t i = 0; i < items.size(); ++i, ++row) {
      if (i >= certificate.size() || certificate[i].limit <= 0.0) continue;
      check.outputs.push_back(kind + items[i].name);
      check.above.push_back(static_cast<int>((errors.row(row).array() > certificate[i].limit).count()));
    }
  };
  const rom::Certificate& certificate = certified.certificate;
  judge(certified.key_points, certificate.key_points_K, "key point ");
  judge(certified.parts, certificate.part_means_K, "mean of ");
  judge(certified.parts, certificate.part_maxima_K, "maximum of ");
  judge(certified.deformations, certificate.deformations_m, "deformation ");
  judge(certified.contact_pressures, certificate.contact_pressures_Pa, "contact pressure ");
  return check;
}

}  // namespace spindle_twin::fem_offline

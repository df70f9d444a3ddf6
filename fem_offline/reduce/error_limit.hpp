#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// Of the limits in a certificate: 95 % of all cases from the box stay below, with a confidence of 95 %.
inline constexpr double limit_content = 0.95;
inline constexpr double limit_confidence = 0.95;
/// Fewer cases give no limit.
inline constexpr int fewest_limiting_cases = 10;

/// Which error of `cases` independent cases, the largest being 1, is a limit by itself, whatever the errors'
/// distribution (S. S. Wilks 1941): the largest k with P(Binomial(cases, 1 − content) < k) <= 1 − confidence. 0 where
/// even the largest is none: below 59 cases for a content of 0.95. `content` in (0, 1).
int limiting_rank(int cases, double content = limit_content);

/// That of `errors` (not empty) which has this rank, the largest being 1. `rank` in 1 … their number.
double error_of_rank(std::vector<double> errors, int rank);

/// k of the one-sided tolerance limit mean + k·deviation of a normal sample of that size (W. A. Shewhart's problem, by
/// the noncentral t distribution: k = t(confidence; n − 1, √n z_content) / √n). `cases` >= 2.
double normal_limit_factor(int cases);

/// The limit that other cases exceed as seldom as limit_content and limit_confidence say, from the largest errors
/// (>= 0) of independent cases of one output: from 59 cases on the error of that rank; with fewer that of a log-normal
/// distribution fitted to them, and not below the largest. 0 below fewest_limiting_cases or where all errors are 0.
double error_limit(std::vector<double> errors);

/// What certificates of so many cases say of their limits.
rom::CertificateLimit limit_rule(int cases);

/// How often cases that a network has not been certified with exceed the limits of its certificate.
struct LimitCheck {
  int cases = 0;
  std::vector<std::string> outputs;  ///< those that have a limit
  std::vector<int> above;            ///< of each: in how many cases it errs more

  /// Of all outputs in all cases.
  double share() const;
};

/// `errors`: of every output (rows in the order of OutputLayout) in every case (columns), SI. Without limits in
/// `certified` no outputs.
LimitCheck check_limits(const rom::Network& certified, const Eigen::MatrixXd& errors);

}  // namespace spindle_twin::fem_offline

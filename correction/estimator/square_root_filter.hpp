#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace spindle_twin::correction {

/// Mean and covariance of a vector z, the covariance as a root: P = D W Wᵀ D with D the prior deviations, so that all
/// entries of W are of order one. W is all that is carried, so P cannot lose its symmetry or its sign.
///   time          P ← P + diag(q)               W from the Cholesky factor of the sum, W Wᵀ + Q conditioned by Q
///   measurement   y = h z + noise, variance r    Potter's update of W, rank one
/// n entries; nothing allocates after the construction, n below 128.
class SquareRootFilter {
 public:
  SquareRootFilter() = default;
  /// Throws std::invalid_argument if the covariance is not positive definite. Allocates.
  SquareRootFilter(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance);

  Eigen::Index size() const { return mean_.size(); }
  const Eigen::VectorXd& mean() const { return mean_; }
  void set_mean(const Eigen::VectorXd& mean) { mean_ = mean; }
  /// Only the first entries.
  void set_first(const Eigen::VectorXd& first) { mean_.head(first.size()) = first; }
  /// Only entry i: z_i ← z_i + by.
  void shift(Eigen::Index i, double by) { mean_[i] += by; }

  /// z ← centre + keep (z − centre), P ← diag(keep) P diag(keep) + diag(variance). keep in (0, 1], variance >= 0.
  void pass_time(const Eigen::VectorXd& centre, const Eigen::VectorXd& keep, const Eigen::VectorXd& variance);

  /// Entry i gets factor_i times its deviation, its correlations stay; then P ← P + diag(variance). A factor of 0 cuts
  /// entry i off from all others. The mean stays. factor >= 0, factor² P_ii + variance > 0.
  void widen(const Eigen::VectorXd& factor, const Eigen::VectorXd& variance);

  /// h P hᵀ.
  double variance_of(const Eigen::VectorXd& h);
  /// h P hᵀ, and P hᵀ in `covariance` (n).
  double variance_of(const Eigen::VectorXd& h, Eigen::VectorXd& covariance);
  /// Same with h only as long as the first entries of z.
  double variance_of_first(const Eigen::VectorXd& h_first);
  /// The same, and P hᵀ of these entries, as long as h_first.
  double variance_of_first(const Eigen::VectorXd& h_first, Eigen::VectorXd& covariance);
  /// Takes in `innovation` = y − h z_now of variance `noise` besides h P hᵀ. Returns whether it was finite.
  bool update(const Eigen::VectorXd& h, double innovation, double noise);

  double deviation(Eigen::Index i) const;
  Eigen::MatrixXd covariance() const;  ///< allocates

  /// W, row after row of z, and D: the whole memory besides the mean.
  const Eigen::MatrixXd& root() const { return root_; }
  const Eigen::VectorXd& scale() const { return scale_; }
  void set_root(const Eigen::MatrixXd& root) { root_ = root; }

 private:
  /// W W^T + diag(variance) / D², factored anew.
  void add_variance(const Eigen::VectorXd& variance);

  Eigen::VectorXd mean_;
  Eigen::VectorXd scale_;  // D
  Eigen::MatrixXd root_;   // W
  Eigen::MatrixXd square_;
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
  Eigen::VectorXd scaled_, projected_, gain_;
};

}  // namespace spindle_twin::correction

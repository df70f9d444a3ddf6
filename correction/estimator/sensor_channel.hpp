#pragma once

#include <Eigen/Core>
#include <limits>

namespace spindle_twin::correction {

/// Response of τ y' = u − y after h seconds in which u runs linearly from u0 to u1; u1 itself without a lag.
/// May run in the cycle.
double lag(double y, double u0, double u1, double h_s, double tau_s);

/// d(lag)/dτ, with dy/dτ = slope before; for τ → 0 that of a pure delay, −(u1 − u0)/h. May run in the cycle.
double lag_slope(double slope, double y, double u0, double u1, double h_s, double tau_s);

/// What one sensor shows of the model, and what it gathers between two updates. Readings and predictions are taken
/// alike, so that their mean difference is an innovation whatever the temperature has done meanwhile. All may run in
/// the cycle but the constructor.
class SensorChannel {
 public:
  /// `internal`: the sensor's row on x; p parameters.
  SensorChannel(Eigen::VectorXd internal, Eigen::Index parameters);

  /// Begins anew: it shows the model's temperature, and nothing was gathered.
  void start(double model_K);
  /// The model at the sensor has gone to model_K within elapsed_s; the sensor follows with lag_s.
  void predict(double model_K, double elapsed_s, double lag_s);
  /// A reading at the instant of the last predict(); not finite: none.
  void observe(double reading_K);
  /// Forgets what was gathered.
  void clear();

  /// Sensitivity of the sensor's place, p; set after each held period.
  void begin_period(const Eigen::VectorXd& place) { before_ = place; }
  void end_period(const Eigen::VectorXd& place, double period_s, double lag_s);
  /// From here on the sensor has shown the place as it is: sensitivities begin at those of the place.
  void set_sensitivity(const Eigen::VectorXd& place) { shown_ = place; }
  /// The same for the parameters from `first` on.
  void set_sensitivity_from(Eigen::Index first, const Eigen::VectorXd& place);
  /// The same for one parameter.
  void set_sensitivity_at(Eigen::Index parameter, double place) { shown_[parameter] = place; }
  void restore(const Eigen::VectorXd& shown, double lag_slope_K_per_s);

  /// A step of the parameters has moved the model: place and what is shown of it. `lag_step_s`: of the lag's estimate.
  void correct(const Eigen::VectorXd& place, const Eigen::VectorXd& step, double lag_step_s);

  const Eigen::VectorXd& internal() const { return internal_; }
  /// d(shown)/dθ at the end of the last held period, p.
  const Eigen::VectorXd& sensitivity() const { return shown_; }
  /// Mean of d(shown)/dτ over the readings gathered, K/s.
  double mean_lag_slope() const { return samples_ > 0 ? lag_slopes_ / samples_ : 0.0; }
  double lag_slope_K_per_s() const { return lag_slope_; }
  int samples() const { return samples_; }
  /// Means over the readings gathered; NaN without one.
  double mean_reading_K() const;
  double mean_residual_K() const;

  double fused_s = never_s;  ///< time of the update that used it last

  static constexpr double never_s = -1e9;

 private:
  Eigen::VectorXd internal_, before_, shown_;
  double temperature_K_ = 0.0;                                      // of the model at the sensor
  double shown_K_ = 0.0;                                            // what the sensor would show of it
  double lag_slope_ = 0.0;                                          // d(shown)/dτ
  double readings_K_ = 0.0, residuals_K_ = 0.0, lag_slopes_ = 0.0;  // sums
  int samples_ = 0;
};

}  // namespace spindle_twin::correction

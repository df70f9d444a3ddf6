#include "correction/estimator/output_deviations.hpp"

#include <algorithm>
#include <cmath>

#include "rom/integrate/output_uncertainty.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double metres_per_micrometre = 1e-6;
constexpr double widest_skewness = 2.0;
/// Points of a part whose temperatures differ by less are equally hot: their order is one of rounding.
constexpr double equally_hot_K = 1e-9;

/// Entry i of a list that older files lack; there the group's own worst error stands for it.
double certificate_of(const std::vector<rom::OutputError>& list, std::size_t i, double group_worst) {
  return rom::certificate_deviation(i < list.size() ? list[i] : rom::OutputError{group_worst, 0.0, 0.0});
}

}  // namespace

DeviationOfOutputs::DeviationOfOutputs(const rom::Network& network, const Sensitivities& sensitivities,
                                       const ParameterModel& parameters, bool skewed) {
  const rom::Certificate& certificate = network.certificate;
  expansion_ = parameters.expansion();
  const auto internal = [&](const Eigen::VectorXd& row) {
    Eigen::VectorXd result(row.size());
    sensitivities.internal_row(row, result);
    return result;
  };
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    key_points_.internal.push_back(internal(network.key_points[k].row));
    key_points_.certificate.push_back(certificate_of(certificate.key_points_K, k, certificate.worst.key_points_K));
  }
  for (std::size_t i = 0; i < network.parts.size(); ++i) {
    const rom::PartOutput& part = network.parts[i];
    part_means_.internal.push_back(internal(part.mean_row));
    part_means_.certificate.push_back(certificate_of(certificate.part_means_K, i, certificate.worst.part_max_K));
    part_maximum_certificate_.push_back(certificate_of(certificate.part_maxima_K, i, certificate.worst.part_max_K));
    candidates_.emplace_back(part.candidate_rows.cols(), part.candidate_rows.rows());
    for (Eigen::Index c = 0; c < part.candidate_rows.rows(); ++c) {
      candidates_.back().col(c) = internal(part.candidate_rows.row(c).transpose());
    }
  }
  for (std::size_t i = 0; i < network.deformations.size(); ++i) {
    deformations_.internal.push_back(internal(network.deformations[i].row_m_per_K));
    deformations_.certificate.push_back(
        certificate_of(certificate.deformations_m, i, metres_per_micrometre * certificate.worst.nose_um));
  }
  for (std::size_t i = 0; i < network.contact_pressures.size(); ++i) {
    pressures_.internal.push_back(internal(network.contact_pressures[i].row_Pa_per_K));
    pressures_.certificate.push_back(certificate_of(certificate.contact_pressures_Pa, i, 0.0));
  }
  sensitivity_ = covariance_ = skew_sign_ = Eigen::VectorXd::Zero(parameters.count());
  for (Eigen::Index i = 0; skewed && i < skew_sign_.size(); ++i) {
    const ParameterKind kind = parameters.list()[static_cast<std::size_t>(i)].kind;
    if (kind == ParameterKind::heat) skew_sign_[i] = 1.0;
    if (kind == ParameterKind::contact || kind == ParameterKind::film) skew_sign_[i] = -1.0;
  }
  x_ = Eigen::VectorXd::Zero(network.capacity_J_per_K.rows());
  const auto sized = [](std::size_t count) { return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(count)).eval(); };
  deviations_ = {sized(network.key_points.size()), sized(network.parts.size()), sized(network.parts.size()),
                 sized(network.deformations.size()), sized(network.contact_pressures.size())};
}

double DeviationOfOutputs::deviation(const Eigen::Ref<const Eigen::VectorXd>& internal, double certificate,
                                     Sensitivities& sensitivities, SquareRootFilter& filter, const LeftOut& left_out) {
  sensitivities.of_row(internal, sensitivity_);
  return deviation(certificate, filter, left_out);
}

double DeviationOfOutputs::deviation(double certificate, SquareRootFilter& filter, const LeftOut& left_out) {
  const double bent = sensitivity_.cwiseProduct(left_out.bend).squaredNorm();
  double alternative = 0.0;
  for (Eigen::Index s = 0; s < alternatives_.cols(); ++s) {
    alternative = std::max(alternative, std::abs(alternatives_.col(s).dot(sensitivity_)));
  }
  const double known = filter.variance_of_first(sensitivity_, covariance_) + bent;
  const double beside = certificate * certificate + alternative * alternative;
  const double variance = known + beside;
  const double deviation = std::sqrt(left_out.scale_factor * left_out.scale_factor * known + beside);
  const double third = 3.0 * (skew_sign_.array() * sensitivity_.array() * covariance_.array().square()).sum();
  const double skewness = variance > 0.0 ? std::abs(third) / (variance * std::sqrt(variance)) : 0.0;
  return deviation * (1.0 + 0.25 * std::min(skewness, widest_skewness));
}

void DeviationOfOutputs::evaluate(const Rows& rows, Sensitivities& sensitivities, SquareRootFilter& filter,
                                  const LeftOut& left_out, Eigen::VectorXd& to) {
  for (std::size_t i = 0; i < rows.internal.size(); ++i) {
    to[static_cast<Eigen::Index>(i)] =
        deviation(rows.internal[i], rows.certificate[i], sensitivities, filter, left_out);
  }
}

void DeviationOfOutputs::evaluate(Sensitivities& sensitivities, SquareRootFilter& filter, const LeftOut& left_out,
                                  const Eigen::VectorXd& nodes_K) {
  if (x_.size() == 0) return;
  sensitivities.to_internal(nodes_K, x_);
  evaluate(key_points_, sensitivities, filter, left_out, deviations_.key_points_K);
  evaluate(part_means_, sensitivities, filter, left_out, deviations_.part_mean_K);
  for (std::size_t i = 0; i < deformations_.internal.size(); ++i) {
    sensitivities.of_row(deformations_.internal[i], sensitivity_);
    if (expansion_ >= 0) {
      double length_m = deformations_.internal[i].dot(x_);
      expand_by(std::exp(filter.mean()[expansion_]), expansion_, length_m, sensitivity_);
    }
    deviations_.deformations_m[static_cast<Eigen::Index>(i)] =
        deviation(deformations_.certificate[i], filter, left_out);
  }
  evaluate(pressures_, sensitivities, filter, left_out, deviations_.contact_pressures_Pa);
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Eigen::MatrixXd& candidates = candidates_[i];
    if (candidates.cols() == 0) continue;
    // One after another, in the order of memory: together they are larger than the cache.
    Eigen::Index hottest = 0;
    double highest = candidates.col(0).dot(x_);
    for (Eigen::Index c = 1; c < candidates.cols(); ++c) {
      const double rise = candidates.col(c).dot(x_);
      if (!(rise > highest + equally_hot_K)) continue;
      highest = rise;
      hottest = c;
    }
    deviations_.part_maximum_K[static_cast<Eigen::Index>(i)] =
        deviation(candidates.col(hottest), part_maximum_certificate_[i], sensitivities, filter, left_out);
  }
}

}  // namespace spindle_twin::correction

#include "correction/calibrate/misfits.hpp"

#include <Eigen/Core>
#include <cmath>

#include "correction/calibrate/in_words.hpp"
#include "correction/estimator/operating_heat.hpp"
#include "rom/units.hpp"

namespace spindle_twin::correction {
namespace {

void add_channels(const CalibrationResult& result, const CalibrateOptions& options, const CalibrateLimits& limits,
                  std::vector<std::string>& misfits) {
  for (const ChannelFit& channel : result.held_out.channels) {
    const bool is_probe = channel.channel >= static_cast<int>(options.sensors.size());
    const double scale = is_probe ? rom::um_per_m : 1.0;
    const char* unit = is_probe ? "um" : "K";
    // Of a probe that was not read before nobody knows the zero: what its readings are off by themselves says nothing.
    const bool zero_is_known = channel.expected_rms < limits.times_expected * limits.held_out_m;
    if (is_probe && zero_is_known && channel.rms > limits.held_out_m) {
      misfits.push_back(in_words("%s, held out: %.2f um rms, at most %.2f um", channel.name.c_str(),
                                 rom::um_per_m * channel.rms, rom::um_per_m * limits.held_out_m));
    }
    if (std::abs(channel.held_out->off) > limits.held_out_mean * channel.held_out->deviation) {
      misfits.push_back(in_words("%s, held out: on average %.3f %s off where the fit is sure to %.3f %s",
                                 channel.name.c_str(), scale * channel.held_out->off, unit,
                                 scale * channel.held_out->deviation, unit));
    }
    if (channel.rms > limits.times_expected * channel.expected_rms) {
      misfits.push_back(in_words("%s, held out: %.3f %s rms where the fit allows for %.3f %s", channel.name.c_str(),
                                 scale * channel.rms, unit, scale * channel.expected_rms, unit));
    }
  }
}

/// Heats that no source explains. One by all readings counts where the last quarter, which the first three had not
/// seen, does not deny it, or where it is very sure: what lies between is as often a model that is a little off.
void add_heats(const CalibrationResult& result, double least_W, const CalibrateLimits& limits,
               std::vector<std::string>& misfits) {
  const auto is_large = [&](const AskedHeat& heat) { return std::abs(heat.heat_W) >= least_W; };
  const HeldOutHeat* const held_out = result.held_out.heat ? &*result.held_out.heat : nullptr;
  const auto is_confirmed = [&](const AskedHeat& heat) {
    return held_out != nullptr && (held_out->after.heat_W > 0.0) == (heat.heat_W > 0.0) &&
           held_out->after.deviations() > limits.asked_after;
  };
  if (held_out != nullptr && is_large(held_out->before) && is_confirmed(held_out->before) &&
      held_out->before.deviations() > limits.asked_before) {
    const auto& [before, after] = *held_out;
    misfits.push_back(
        in_words("held out: before the last quarter readings ask for %.3g W +- %.2g W in %s that no source explains, "
                 "in it for %.3g W +- %.2g W",
                 before.heat_W, before.deviation_W, before.group.c_str(), after.heat_W, after.deviation_W));
  }
  for (const AskedHeat& heat : result.asked) {
    const double least = is_confirmed(heat) ? limits.asked_heat : limits.asked_heat_alone;
    if (heat.deviations() <= least || !is_large(heat)) continue;
    misfits.push_back(in_words("the readings ask for %.3g W +- %.2g W in %s that no source explains", heat.heat_W,
                               heat.deviation_W, heat.group.c_str()));
  }
}

/// How a probe's readings of one log go with what was foreseen of them.
struct Regression {
  double slope = 0.0, correlation = 0.0, foreseen_rms_m = 0.0;
};

Regression regression_of(const TestPrediction& before, int channel) {
  std::vector<double> foreseen, read;
  for (const TestReading& reading : before.readings) {
    if (reading.channel != channel) continue;
    foreseen.push_back(reading.value - reading.residual);
    read.push_back(reading.value);
  }
  if (read.size() < 3) return {};
  const auto count = static_cast<Eigen::Index>(read.size());
  Eigen::VectorXd x = Eigen::Map<Eigen::VectorXd>(foreseen.data(), count);
  Eigen::VectorXd y = Eigen::Map<Eigen::VectorXd>(read.data(), count);
  x.array() -= x.mean();
  y.array() -= y.mean();
  if (!(x.norm() > 0.0 && y.norm() > 0.0)) return {};
  return {x.dot(y) / x.squaredNorm(), x.dot(y) / (x.norm() * y.norm()),
          x.norm() / std::sqrt(static_cast<double>(count))};
}

}  // namespace

std::vector<std::string> misfits_of(const CalibrationResult& result, const rom::Network& network,
                                    const CalibrateOptions& options, const CalibrateLimits& limits) {
  std::vector<std::string> misfits;
  if (result.fit.chi_square_per_reading > limits.chi_square) {
    misfits.push_back(in_words("all readings together: chi-square %.2f per reading, at most %.2f",
                               result.fit.chi_square_per_reading, limits.chi_square));
  }
  add_channels(result, options, limits, misfits);
  add_heats(result, limits.asked_share * nominal_heats_W(network), limits, misfits);
  return misfits;
}

std::vector<std::string> hints_of(const CalibrationResult& result, const rom::Network& network,
                                  const CalibrateOptions& options) {
  constexpr double least_correlation = 0.8, least_m = 1e-6;
  std::vector<std::string> hints;
  for (std::size_t test = 0; test < result.before.size(); ++test) {
    for (std::size_t d = 0; d < network.deformations.size(); ++d) {
      const int channel = static_cast<int>(options.sensors.size() + d);
      const Regression of = regression_of(result.before[test], channel);
      if (std::abs(of.correlation) < least_correlation || of.foreseen_rms_m < least_m) continue;
      if (of.slope > 0.25 && of.slope < 4.0) continue;
      const double times = std::abs(of.slope);
      const char* unit = times < 4e-3 && times > 2.5e-4    ? "; is it in mm, not um?"
                         : times > 250.0 && times < 4000.0 ? "; is it in nm, not um?"
                                                           : "";
      const char* sign = of.slope < 0.0 ? "; + must be a spindle that is longer" : "";
      hints.push_back(in_words("%s, log %zu: reads %.3g times what was foreseen%s%s",
                               network.deformations[d].name.c_str(), test + 1, of.slope, unit, sign));
    }
  }
  return hints;
}

}  // namespace spindle_twin::correction

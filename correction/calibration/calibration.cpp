#include "correction/calibration/calibration.hpp"

#include <algorithm>
#include <string_view>

#include "correction/estimator/parameters.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/sha256.hpp"

namespace spindle_twin::correction {

double drift_of(const std::string& name, const DriftOptions& drift) {
  if (name.starts_with(name_of(ParameterKind::heat))) return drift.heat;
  if (name.starts_with(name_of(ParameterKind::contact))) return drift.contact;
  if (name.starts_with(name_of(ParameterKind::film))) return drift.film;
  return 0.0;
}

std::shared_ptr<const CalibratedPrior> prior_of(const Calibration& calibration, const DriftOptions& drift) {
  auto prior = std::make_shared<CalibratedPrior>();
  const std::vector<std::uint8_t> bytes = encode_calibration(calibration);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  prior->origin = rom::sha256_hex(text);
  DriftOptions::each(drift, [&](const rom::Option& option, double value) {
    prior->origin.append(1, ' ').append(option.key).append(1, ' ').append(std::to_string(value));
  });
  prior->made_unix_s = calibration.made_unix_s;
  prior->promised_m = calibration.promised_m;
  prior->names = calibration.names;
  prior->mean = calibration.mean;
  prior->nominal = calibration.nominal;
  prior->covariance = calibration.root * calibration.root.transpose();
  add_drift(drift, *prior);
  return prior;
}

void add_drift(const DriftOptions& drift, KnownParameters& known) {
  for (std::size_t i = 0; i < known.names.size(); ++i) {
    const double deviation = drift_of(known.names[i], drift);
    const auto slot = static_cast<Eigen::Index>(i);
    known.covariance(slot, slot) += deviation * deviation;
  }
}

void check_fits(const Calibration& calibration, const rom::Network& network, EstimatorPriors priors,
                const std::string& file) {
  if (calibration.spindle != network.spindle) {
    throw rom::InputError(
        {file, 0}, "spindle",
        "\"" + calibration.spindle + "\" was calibrated, and the network is of \"" + network.spindle + "\"");
  }
  priors.calibrated = nullptr;
  const ParameterModel parameters(network, priors);
  for (const std::string& name : calibration.names) {
    const bool known = std::any_of(parameters.list().begin(), parameters.list().end(),
                                   [&](const Parameter& parameter) { return parameter.name == name; });
    if (!known)
      throw rom::InputError({file, 0}, "names",
                            "the network has no \"" + name + "\" with these priors, which was calibrated");
  }
}

}  // namespace spindle_twin::correction

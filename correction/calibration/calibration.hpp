#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "correction/estimator/calibrated_prior.hpp"
#include "correction/estimator/parameters.hpp"
#include "rom/file/keys.hpp"
#include "rom/network.hpp"
#include "rom/option.hpp"

namespace spindle_twin::correction {

/// What a commissioning test has left of the parameters of one machine.
struct Calibration {           // NOLINT(public-members): a file as it is written, field by field
  std::string spindle;         ///< name of the network
  std::string network_sha256;  ///< hex, of the network that it was made with
  double made_unix_s = 0.0;
  double tested_s = 0.0;           ///< length of all logs together
  std::vector<std::string> logs;   ///< as they were called
  std::vector<std::string> names;  ///< n parameters, as Parameter::name
  Eigen::VectorXd mean;
  Eigen::MatrixXd root;  ///< n x n lower triangle, covariance = root rootᵀ
  Eigen::VectorXd prior_mean, prior_deviation;
  Eigen::VectorXd nominal = {};  ///< as in KnownParameters; empty in files of before
  double promised_m = 0.0;  ///< 1σ of the first deformation output after four hours without a sensor (NosePromise)
  bool accepted = true;     ///< it kept its limits; false: a person has written it all the same
};

/// How far a machine may have changed since its test, or in a long absence of its twin, 1σ of ln factors. Small steps
/// of use and season: a bearing's grease and preload, joints that settle, fouling of the coolant's channels.
struct DriftOptions {
  double heat = 0.05;
  double contact = 0.10;
  double film = 0.05;

  template <class Options, class Visit>
  static void each(Options& drift, Visit&& visit) {
    constexpr double most = 2.0;
    visit(rom::zero_or_some("heat", "of each heat source since the test", most), drift.heat);
    visit(rom::zero_or_some("contact", "of each contact", most), drift.contact);
    visit(rom::zero_or_some("film", "of each film", most), drift.film);
  }
};

/// 1σ of how far a parameter of this name may have changed since the test: heats, contacts and films by how their names
/// begin, 0 of all others.
double drift_of(const std::string& name, const DriftOptions& drift);

/// Adds its square to the variance of each.
void add_drift(const DriftOptions& drift, KnownParameters& known);

/// Posterior and drift together: covariance = root rootᵀ + diag(drift_of²). Allocates.
std::shared_ptr<const CalibratedPrior> prior_of(const Calibration& calibration, const DriftOptions& drift);

/// Throws rom::InputError naming `file`, and why, where the calibration is of another spindle or names a parameter that
/// this network does not have with these priors. Another network of the same spindle, with other nodes or nominal
/// values, is exact: all parameters are of its borders.
void check_fits(const Calibration& calibration, const rom::Network& network, EstimatorPriors priors,
                const std::string& file);

/// What a file holds, and whose signature fits it; whether to trust that key is the reader's question.
struct CalibrationFile {
  Calibration calibration;
  std::optional<rom::PublicKey> signed_by;
};

/// The file's bytes: a line with format and SHA-256, then the message of calibration.proto. With a key the line says
/// that the file is signed, and a block with the signature of all before it ends it (rom/file/signature.hpp).
std::vector<std::uint8_t> encode_calibration(const Calibration& calibration, const rom::PrivateKey* key = nullptr);
/// Throws rom::InputError naming `file` for anything else than what encode_calibration made: damage by a single bit,
/// another version, a signature that does not fit, sizes that disagree, numbers that are none, a root without a
/// positive diagonal.
CalibrationFile decode_calibration(const std::vector<std::uint8_t>& bytes, const std::string& file);
/// Whole or not at all. Throws rom::InputError with the system's reason.
void write_calibration(const Calibration& calibration, const std::string& path, const rom::PrivateKey* key = nullptr);
CalibrationFile read_calibration_file(const std::string& path);
Calibration read_calibration(const std::string& path);

}  // namespace spindle_twin::correction

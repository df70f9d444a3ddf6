#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/parameter_box.hpp"
#include "fem_offline/reduce/reduce.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// Inputs that are held for a while; outputs are compared at its end.
struct HeldInterval {
  double duration_s = 0.0;
  rom::OperatingState state;
};

/// A random hour or two of a spindle's life with parameters anywhere in the box.
struct VerifyCase {
  rom::CorrectionFactors factors;
  double initial_temperature_K = 0.0;  ///< uniform
  std::vector<HeldInterval> intervals;
};

/// Case `index` of `seed`, a function of these two alone: contacts log-uniform 0.1 to 10, films 0.2 to 5; 1 to 2 h in
/// segments of 60 to 900 s, each with a new speed (a quarter of them at rest), load and coolant flow; coolant steps of
/// up to ±5 K at every third segment; ambient that drifts by up to ±6 K/h. Intervals are 1, 1, 2, 4, 8, 16 s long after
/// every segment's start, then longest_interval_s.
VerifyCase random_case(const rom::Boundaries& boundaries, std::uint64_t seed, std::uint32_t index,
                       const ParameterBox& box = {});

inline constexpr double longest_interval_s = 32.0;

struct VerifyOptions {
  std::uint32_t cases = 20;
  std::uint64_t seed = 1;
  int threads = 2;
  /// Longest time step of the FE solution; after a jump its steps are shorter anyway. Against 8 s the default moves the
  /// reference spindle's figures by about 0.001 K and 0.001 um (README.md names the command).
  double fe_step_s = 32.0;
  ParameterBox box;
};

struct NamedError {
  std::string name;
  double worst = 0.0;
};

/// Errors of one network: network minus FE model, largest magnitude over the run.
struct VerifyReport {
  rom::Certificate certificate;               ///< worst and median over the cases
  std::vector<rom::CertificateErrors> cases;  ///< in order of their index
  std::vector<NamedError> key_points_K;       ///< worst over the cases
  std::vector<NamedError> part_max_K;
  std::vector<NamedError> deformations_um;
};

/// Runs network (CVODE with the runtime's own settings) and FE model beside each other through random cases.
/// The network must come from `model`: same boundaries, key points, parts and deformations in the same order, else
/// std::invalid_argument. std::runtime_error if the network's integrator fails.
VerifyReport verify_network(const rom::Network& network, const AffineModel& model, const VerifyOptions& options,
                            const Progress& progress = {});

}  // namespace spindle_twin::fem_offline

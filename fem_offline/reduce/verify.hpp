#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/reduce.hpp"
#include "fem_offline/reduce/tolerance.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

struct VerifyOptions {
  std::uint32_t cases = 20;
  std::uint64_t seed = 1;
  int threads = 2;
  /// None: the FE solution is exact in time (run_fe_model). Else its longest step: README.md names the command that
  /// compares the two.
  std::optional<double> fe_step_s = {};
  CaseOptions drive;
};

/// Errors of one network: network minus FE model, largest magnitude over the run.
struct VerifyReport {
  rom::Certificate certificate;               ///< worst, median, limit over the cases; its errors of the mesh stay 0
  std::vector<rom::CertificateErrors> cases;  ///< in order of their index
  Eigen::MatrixXd errors;                     ///< SI; a row per output (OutputLayout), a column per case
};

/// Runs network (CVODE with the runtime's own settings) and FE model beside each other through random cases.
/// The network must come from `model`: same boundaries, key points, parts, deformations and contact pressures in the
/// same order, else std::invalid_argument. std::runtime_error if the network's integrator fails.
VerifyReport verify_network(const rom::Network& network, const AffineModel& model, const VerifyOptions& options,
                            const Progress& progress = {});

/// As many cases as give a limit whatever their distribution (limiting_rank), and how many are added at a time.
inline constexpr std::uint32_t cases_of_any_distribution = 59;
inline constexpr std::uint32_t cases_more = 13;

/// The same with cases_more cases again and again, as long as missed_limits has something to say and there are fewer
/// than cases_of_any_distribution: few cases give a limit that is wide, not one that is wrong. None are added where an
/// error exceeds what is wanted in a case that is known: then no limit can keep it.
VerifyReport verify_until(const rom::Network& network, const AffineModel& model, const VerifyOptions& options,
                          const Tolerance& wanted, const Progress& progress = {});

}  // namespace spindle_twin::fem_offline

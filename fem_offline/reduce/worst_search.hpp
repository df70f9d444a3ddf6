#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/parameter_box.hpp"
#include "fem_offline/reduce/reduce.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

struct WorstSearchOptions {
  int cases = 400;  ///< jumps that are tried, rounded up to dozens
  std::uint64_t seed = 1;
  int threads = 2;
  ParameterBox box;
};

/// A jump: the steady state of `before`, or all at one temperature, and then `after` for worst_search_s.
struct JumpCase {
  rom::CorrectionFactors factors;
  std::optional<double> uniform_start_K;  ///< in place of the steady state
  rom::OperatingState before, after;
};
inline constexpr double worst_search_s = 512.0;

/// Where a network errs most, as far as a search has found: of each kind of CertificateErrors the largest error, the
/// output that has it, and the jump behind which it has.
struct WorstFound {
  struct Kind {
    double error = 0.0;  ///< K or um
    std::string output;
    JumpCase jump;
  };
  int cases = 0;
  Kind key_points, nose, part_maxima;

  rom::CertificateErrors errors() const { return {key_points.error, nose.error, part_maxima.error}; }
};

/// Looks for the jumps of the box (factors, speeds, loads, starts, surroundings as far from the operating state as
/// drive cycles take them, flows) behind which `network` errs most against `model`, which it was built from. A quarter
/// of the jumps are drawn, half of those at corners; the others change a few coordinates of the worst so far, of each
/// kind of error in turn, and are kept where they are worse. A function of seed and options but for `threads`.
/// std::invalid_argument for options out of range, std::runtime_error where an integrator fails.
WorstFound search_worst(const rom::Network& network, const AffineModel& model, const WorstSearchOptions& options,
                        const Progress& progress = {});

}  // namespace spindle_twin::fem_offline

#pragma once

#include <string>
#include <vector>

#include "correction/estimator/estimator_correction.hpp"

namespace spindle_twin::firmware {

/// A CSV with a row per parameter: posterior against prior, ln of factors where the name says heat, contact or film.
/// `determined` is 0 where the sensors tell less than a tenth of the prior deviation. Equally long lists.
std::string parameters_csv(const std::vector<correction::Parameter>& parameters,
                           const std::vector<correction::ParameterEstimate>& estimates);

/// One sentence: how many and which the sensors determine, and of which they say nothing.
std::string what_is_determined(const std::vector<correction::Parameter>& parameters,
                               const std::vector<correction::ParameterEstimate>& estimates);

/// One sentence on the heats that no source explains, as far as they are further from zero than two of their
/// deviations; empty where there is none.
std::string unexplained_heats(const std::vector<correction::Parameter>& parameters,
                              const std::vector<correction::ParameterEstimate>& estimates);

}  // namespace spindle_twin::firmware

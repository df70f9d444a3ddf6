#pragma once

#include <string>

#include "firmware/cycle/snapshot.hpp"
#include "firmware/show/shown_names.hpp"

namespace spindle_twin::firmware {

/// What no register has of the correction factors, as a member of the state: of the ln of each factor the prior's mean
/// and deviation (1 sigma) at the present speed and temperatures, and the estimate's deviation; null where there is
/// none:
///   "factors":{"heat":{NAME:{"prior_ln_mean":0.1,"prior_ln_sd":0.5,"ln_sd":0.08}},"conductance":{NAME:{...}}}
/// Allocates.
std::string factors_json(const Snapshot& snapshot, const ShownNames& names);

}  // namespace spindle_twin::firmware

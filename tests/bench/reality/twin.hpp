#pragma once

#include "tests/bench/campaign/models.hpp"

namespace spindle_twin::bench {

/// The network of the other campaigns with a certificate, as the daemon meets it; kept in the cache.
rom::Network certified_twin(const TwinOptions& options);

}  // namespace spindle_twin::bench

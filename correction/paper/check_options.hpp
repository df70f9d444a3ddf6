#pragma once

#include "correction/paper/paper_options.hpp"

namespace spindle_twin::correction {

/// Throws rom::InputError naming the option and what is allowed; `options.groups` must be filled.
void check_options(const rom::Network& network, const PaperOptions& options);

}  // namespace spindle_twin::correction

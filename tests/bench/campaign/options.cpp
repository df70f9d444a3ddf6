#include "tests/bench/campaign/options.hpp"

namespace spindle_twin::bench {

void add_options(CommandLine& line, CampaignOptions& options, const char* what_a_run_is, const char* what_short_is) {
  line.add("--runs", options.runs, what_a_run_is, Allowed{1, 10000});
  line.add("--nodes", options.twin.nodes, "of the twin", Allowed{20, 400});
  line.add("--threads", options.twin.threads, "that work at once", Allowed{1, 256});
  line.add("--seed", options.seed, "of all that is drawn");
  line.add("--twin-mm", options.twin.element_size_mm, "element size of the twin's FE model");
  line.add("--truth-mm", options.truth_mm, "element size of the truth's FE model");
  line.add("--cache", options.twin.cache, "folder that keeps network and truths, so that a stopped campaign goes on");
  line.add_flag("--short", options.is_short, what_short_is);
}

}  // namespace spindle_twin::bench

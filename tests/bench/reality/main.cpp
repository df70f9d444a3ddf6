#include <algorithm>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <stdexcept>

#include "tests/bench/campaign/options.hpp"
#include "tests/bench/reality/tables.hpp"
#include "tests/bench/reality/twin.hpp"

namespace spindle_twin::bench {
namespace {

constexpr std::uint64_t seeds_apart = 100000;  // none of twin_campaign's

struct Options : CampaignOptions {
  std::vector<std::string> families;
  int first = 0;
  double cycle_s = 2.0;
  bool verbose = false;
  std::string csv;
  std::string heading;
  std::string trace;
  std::string resume;
  bool judge_only = false;
  Unplugging unplugging;
  bool put_back_right = false;
  std::string present = SPINDLE_TWIN_SOURCE_DIR "/tests/bench/reality/present.csv";
};

/// All families of one truth of one spindle, so that it is made once.
struct Task {
  TruthKind truth = TruthKind::nominal;
  std::uint64_t seed = 0;
  std::vector<const Family*> families;
};

std::vector<Family> chosen_families(const Options& options) {
  std::vector<std::string> names = options.families;
  if (options.is_short && names.empty())
    names = {"nominal", "warm_restart", "flow_halved", "lag_30s", "gaps_held", "exchanged"};
  if (names.empty()) return all_families();
  std::vector<Family> chosen;
  for (const Family& family : all_families()) {
    if (std::erase(names, family.name) > 0) chosen.push_back(family);
  }
  if (names.empty()) return chosen;
  std::string known;
  for (const Family& family : all_families()) known += " " + family.name;
  throw std::runtime_error("no family \"" + names.front() + "\"; there are" + known);
}

int runs_of(const Family& family, const Options& options) {
  const bool twice = family.name == nominal_family().name && !options.is_short && options.trace.empty();
  return std::min(family.most_runs, twice ? 2 * options.runs : options.runs);
}

std::vector<Task> make_tasks(const std::vector<Family>& families, const Scores& done, const Options& options) {
  std::vector<Task> tasks;
  for (int number = 0; number < 2 * options.runs; ++number) {
    for (const Family& family : families) {
      if (number >= runs_of(family, options)) continue;
      const std::uint64_t seed = seeds_apart * options.seed + static_cast<std::uint64_t>(options.first + number);
      if (done.contains({family.name, seed})) continue;
      auto found = std::find_if(tasks.begin(), tasks.end(),
                                [&](const Task& task) { return task.truth == family.truth && task.seed == seed; });
      if (found == tasks.end()) found = tasks.insert(tasks.end(), {family.truth, seed, {}});
      found->families.push_back(&family);
    }
  }
  return tasks;
}

/// How many limits were missed.
int judge(const Options& options, const std::vector<Family>& families, const Scores& scores, const Scores& present) {
  print_families(families, scores, present);
  return options.is_short ? print_short_limits(families, scores) : print_reality_limits(families, scores, present);
}

int run(const Options& options) {
  const std::vector<Family> families = chosen_families(options);
  const Scores present = options.is_short ? Scores{} : read_scores(options.present);
  Scores scores = read_scores(options.resume);
  if (options.judge_only) return judge(options, families, scores, present);
  const rom::Network network = certified_twin(options.twin);
  const TruthStore truths(options.twin.cache, options.truth_mm);
  std::printf(
      "reality_campaign --seed %llu: seeds from %llu on, %d runs a family%s; daemon's "
      "cycle of %g s, default options, six sensors; twin: %zu nodes from %g mm; truth: %g mm\n",
      static_cast<unsigned long long>(options.seed),
      static_cast<unsigned long long>(seeds_apart * options.seed + static_cast<std::uint64_t>(options.first)),
      options.runs, runs_of(nominal_family(), options) > options.runs ? ", the nominal one twice as many" : "",
      options.cycle_s, network.nodes.size(), options.twin.element_size_mm, options.truth_mm);
  for (const bool inside : {true, false}) {
    std::printf("%s the filter's priors:", inside ? "Inside" : "Outside");
    for (const Family& family : families) {
      if (family.inside_priors == inside) std::printf(" %s", family.name.c_str());
    }
    std::printf("\n");
  }
  std::printf("present: %zu runs of %s\n", present.size(), options.present.c_str());
  std::fflush(stdout);

  const std::vector<Task> tasks = make_tasks(families, scores, options);
  std::ofstream trace;
  if (!options.trace.empty()) trace.open(options.trace);
  std::mutex noting;
  std::size_t done = 0;
  in_parallel(options.twin.threads, static_cast<int>(tasks.size()), [&](int i) {
    const Task& task = tasks[static_cast<std::size_t>(i)];
    const RealityTruth truth = truths.get(task.truth, task.seed);
    for (const Family* family : task.families) {
      const RealityScore score = follow_reality(network, truth, *family, options.cycle_s, options.unplugging,
                                                trace.is_open() ? &trace : nullptr);
      const std::lock_guard lock(noting);
      scores[{family->name, task.seed}] = score;
      if (options.verbose) print_run(family->name, score);
    }
    const std::lock_guard lock(noting);
    std::fprintf(stderr, "truth %zu of %zu\n", ++done, tasks.size());
    if (!options.csv.empty()) write_scores(options.csv, options.heading, scores);
  });
  if (options.unplugging.for_s > 0.0) {
    print_families(families, scores, {});
    return print_pairs(families, scores, options.unplugging);
  }
  return judge(options, families, scores, present);
}

}  // namespace
}  // namespace spindle_twin::bench

int main(int argc, char** argv) {
  using namespace spindle_twin::bench;
  Options options;
  CommandLine line("reality_campaign: the daemon's own cycle on virtual spindles outside its priors");
  options.runs = 16;
  add_options(line, options, "of 2 h for each family, nominal twice as many",
              "one run of a few families with coarse models, for a quick look");
  line.add("--family", options.families, "only this one; may be given again");
  line.add("--first", options.first, "number of the first spindle", Allowed{0, 99999});
  line.add("--cycle-s", options.cycle_s, "period of the daemon, where the family has none of its own",
           Allowed{0.1, 10.0});
  line.add_flag("--verbose", options.verbose, "a line per run");
  line.add("--csv", options.csv, "file for the score of each run");
  line.add("--heading", options.heading, "comment for that file");
  line.add("--trace", options.trace, "file for the time series of a single run: one --family, --runs 1");
  line.add("--resume", options.resume, "scores of such a file: what stands there is not run again");
  line.add_flag("--judge", options.judge_only, "run nothing: tables and limits of the scores of --resume");
  line.add("--unplugged-s", options.unplugging.for_s,
           "two sensors, drawn for each spindle, are silent for so long, until an hour, and come back exchanged",
           Allowed{0.0, 3000.0});
  line.add_flag("--put-back-right", options.put_back_right, "they come back in their own places");
  line.need("--put-back-right", "--unplugged-s");
  line.add("--present", options.present, "scores of the filter to compare with");
  if (const auto code = line.parse(argc, argv)) return *code;
  settle(options);
  options.unplugging.exchanged = !options.put_back_right;
  if (options.is_short) options.cycle_s = 5.0;
  if (!options.trace.empty() && (options.families.size() != 1 || options.runs != 1)) {
    std::fprintf(stderr, "--trace needs one --family and --runs 1\n");
    return 2;
  }
  if (options.unplugging.for_s > 0.0 && !options.resume.empty()) {
    std::fprintf(stderr, "--unplugged-s: scores of --resume do not say what became of a pair\n");
    return 2;
  }
  try {
    return run(options) == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "reality_campaign: %s\n", error.what());
    return 2;
  }
}

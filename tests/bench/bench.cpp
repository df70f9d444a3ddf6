#include <omp.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <exception>
#include <vector>

#include "tests/bench/rows.hpp"

/// bench_rows: our own rows of the table that tests/bench/run prints, as lines of JSON; or one of our times beside a
/// time of another program, as one number; or a bare factor's cost.
namespace spindle_twin::bench {
namespace {

struct Options {
  std::string run;
  std::string group;
  std::string daemon;
  std::string spindle;
  std::string factored;
  std::vector<std::string> schedule;
};

void print(const Options& options) {
  if (!options.spindle.empty()) {
    std::printf("%.9f\n", step_seconds(options.spindle));
    return;
  }
  if (!options.schedule.empty()) {
    std::printf("%.9f\n", schedule_seconds(options.schedule[0], options.schedule[1]));
    return;
  }
  if (!options.factored.empty()) {
    const FactorCost cost = factor_cost(options.factored);
    std::printf("{\"unknowns\": %ld, \"factor_s\": %.9f, \"solve_s\": %.9f, \"bytes\": %.0f}\n", cost.unknowns,
                cost.factor_s, cost.solve_s, cost.bytes);
    return;
  }
  const RowPrinter printer(options.run);
  if (options.group == "fem") print_fem_rows(printer);
  if (options.group == "network") print_network_rows(printer);
  if (options.group == "estimator") print_estimator_rows(printer);
  if (options.group == "cycle") print_cycle_rows(printer);
  if (options.group == "registers") print_register_rows(printer, options.daemon);
}

int run(int argc, char** argv) {
  CLI::App app("Our own rows of tests/bench/run.");
  Options options;
  app.require_option(1, 3);
  CLI::Option* run = app.add_option("--run", options.run, "name of the run that the rows carry");
  CLI::Option* group =
      app.add_option("--group", options.group, "which rows")
          ->check(CLI::IsMember(std::vector<std::string>{"fem", "network", "estimator", "cycle", "registers"}))
          ->needs(run);
  run->needs(group);
  app.add_option("--daemon", options.daemon, "spindle-twind, for the group registers")->needs(group);
  app.add_option("--step", options.spindle, "processor seconds of one transient step of this spindle, 0.5 s long");
  app.add_option("--factor", options.factored,
                 "what a bare CHOLMOD takes for the thermal matrix of this spindle, as JSON");
  app.add_option("--schedule", options.schedule,
                 "NETWORK.rom SCHEDULE.csv: processor seconds of the network over the schedule in cycles of 1 s")
      ->expected(2);
  CLI11_PARSE(app, argc, argv);
  try {
    print(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_rows: %s\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace spindle_twin::bench

int main(int argc, char** argv) {
  omp_set_max_active_levels(0);
  return spindle_twin::bench::run(argc, argv);
}

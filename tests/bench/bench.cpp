#include <omp.h>
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "tests/bench/rows.hpp"

namespace spindle_twin::bench {
namespace {

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

fem_offline::FeModel reference_model(double element_size_mm, bool thermal_only) {
  fem_offline::Spindle spindle =
      fem_offline::read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference.toml");
  spindle.mesh.element_size_m = 1e-3 * element_size_mm;
  if (thermal_only) {
    spindle.deformations.clear();
    spindle.contact_pressures.clear();
    spindle.stress_probes.clear();
    spindle.supports.clear();
  }
  return {spindle, fem_offline::build_section(spindle)};
}

double thread_seconds(int repeats, const std::function<void()>& work) {
  double least_s = std::numeric_limits<double>::max();
  for (int i = 0; i < repeats; ++i) {
    const double start_s = seconds_of(CLOCK_THREAD_CPUTIME_ID);
    work();
    least_s = std::min(least_s, seconds_of(CLOCK_THREAD_CPUTIME_ID) - start_s);
  }
  return least_s;
}

double process_seconds(const std::function<void()>& work) {
  const double start_s = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
  work();
  return seconds_of(CLOCK_PROCESS_CPUTIME_ID) - start_s;
}

void print_row(const std::string& what, double value, const std::string& unit, const std::string& goal) {
  std::printf("  %-68s %10.3g %-4s %s\n", what.c_str(), value, unit.c_str(), goal.c_str());
  std::fflush(stdout);
}

}  // namespace spindle_twin::bench

/// bench_rows: all rows of our own.
/// bench_rows --network, --estimator: those rows only.
/// bench_rows --step SPINDLE.toml: processor seconds of one transient step of 0.5 s.
/// bench_rows --schedule X.rom S.csv: processor seconds of a network over a schedule in cycles of 1 s.
int main(int count, char** arguments) {
  omp_set_max_active_levels(0);
  if (count == 3 && std::string(arguments[1]) == "--step") {
    std::printf("%.6f\n", spindle_twin::bench::step_seconds(arguments[2]));
    return 0;
  }
  if (count == 4 && std::string(arguments[1]) == "--schedule") {
    std::printf("%.6f\n", spindle_twin::bench::schedule_seconds(arguments[2], arguments[3]));
    return 0;
  }
  if (count == 2 && std::string(arguments[1]) == "--network") {
    spindle_twin::bench::print_network_rows();
    return 0;
  }
  if (count == 2 && std::string(arguments[1]) == "--estimator") {
    spindle_twin::bench::print_estimator_rows();
    return 0;
  }
  spindle_twin::bench::print_fem_rows();
  spindle_twin::bench::print_network_rows();
  spindle_twin::bench::print_estimator_rows();
}

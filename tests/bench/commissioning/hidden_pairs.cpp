#include "tests/bench/commissioning/hidden_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/bench/commissioning/commission.hpp"
#include "tests/bench/in_parallel.hpp"

namespace spindle_twin::bench {
namespace {

constexpr std::array<std::uint64_t, 2> hiding_seeds{1026, 2002};
constexpr double day_s = 7200.0;
constexpr double least_inside = 0.9;  // of a day's samples, and of a machine's hidden parameters

bool hides(const std::string& name) {
  return name == "heat front_bearings" ||
         (name.starts_with("contact") && name.find("front_balls") != std::string::npos);
}

int keeps(const char* what, double reached, double least) {
  std::printf("    %-52s %6.2f  at least %4.2f  %s\n", what, reached, least, reached >= least ? "kept" : "MISSED");
  return reached >= least ? 0 : 1;
}

int judge(const Commissioned& machine, std::size_t set) {
  const Service& day = machine.days[0];
  std::printf(
      "  %d sensors: nose %.2f um without a test, %.1f of its own sigma (inside %.2f), %.2f um with it, sigma %.2f; %d "
      "runs of the model\n",
      permanent_sensors[set], day.without_test[set].error_um,
      day.without_test[set].error_um / day.without_test[set].deviation_um, day.without_test[set].inside,
      day.with_test[set].error_um, day.with_test[set].deviation_um, machine.evaluations[set]);
  std::printf("    starts, cost and deviations from the best:");
  for (const correction::StartedFit& start : machine.starts[set]) {
    std::printf("  %.2f %.2f%s", start.cost, start.apart, start.is_other ? " (another minimum)" : "");
  }
  std::printf("\n");
  const std::vector<double>& off = machine.off[set];
  double inside = 0.0, hiding = 0.0, hiding_inside = 0.0;
  for (std::size_t i = 0; i < off.size(); ++i) {
    const std::string& name = machine.calibrations[set].names[i];
    const bool is_inside = std::abs(off[i]) <= 2.0;
    inside += is_inside ? 1.0 : 0.0;
    if (hides(name)) {
      hiding += 1.0;
      hiding_inside += is_inside ? 1.0 : 0.0;
    }
    if (!is_inside || hides(name)) std::printf("    %-60s %+5.1f sigma\n", name.c_str(), off[i]);
  }
  // Three sensors in the rear sleeve tell nothing of the front bearing.
  const int missed_before = permanent_sensors[set] < 6 ? 0
                                                       : keeps("without a test: nose inside +-2 sigma, of the day",
                                                               day.without_test[set].inside, least_inside);
  return missed_before + keeps("nose inside +-2 sigma, share of the day", day.with_test[set].inside, least_inside) +
         keeps("front bearing's heat and ball contacts inside", hiding_inside / hiding, 1.0) +
         keeps("hidden parameters inside", inside / static_cast<double>(off.size()), least_inside);
}

}  // namespace

int check_hidden_pairs(const rom::Network& network, const fem_offline::AffineModel& truth_model, int threads) {
  TestPlan plan;
  plan.service_s = day_s;
  plan.expansion = 0.0;  // of these two in the twin campaign
  std::array<Commissioned, hiding_seeds.size()> machines;
  in_parallel(threads, static_cast<int>(machines.size()), [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    machines[at] = commission(network, truth_model, hiding_seeds[at], HeatErrors::independent, plan);
  });
  int missed = 0;
  for (const Commissioned& machine : machines) {
    std::printf("spindle %llu\n", static_cast<unsigned long long>(machine.seed));
    for (std::size_t set = 0; set < permanent_sensors.size(); ++set) missed += judge(machine, set);
  }
  std::printf("%d limits missed\n", missed);
  return missed;
}

}  // namespace spindle_twin::bench

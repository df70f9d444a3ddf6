#include "tests/bench/reality/families.hpp"

#include <tuple>
#include <utility>

namespace spindle_twin::bench {
namespace {

std::vector<Family> make_families() {
  std::vector<Family> families;
  families.reserve(64);  // references into it are kept below
  const auto add = [&](const char* name, TruthKind truth = TruthKind::nominal) -> Family& {
    families.emplace_back();
    families.back().name = name;
    families.back().truth = truth;
    return families.back();
  };
  const auto limit = [](Family& family, std::vector<ErrorLimit> error_limits, double least_inside,
                        double least_inside_of_a_run = 0.0) {
    family.error_limits = std::move(error_limits);
    family.least_inside = least_inside;
    family.least_inside_of_a_run = least_inside_of_a_run;
  };

  Family& base = add("nominal");
  base.inside_priors = base.must_run = true;
  limit(base, {{Measure::present, 1.05}}, 0.95, 0.80);
  Family& warm = add("warm_restart", TruthKind::warm);
  warm.must_run = true;
  limit(warm, {{Measure::nominal, 1.2}, {Measure::open_loop, 0.25}}, 0.95, 0.80);
  add("cold_restart", TruthKind::cold).must_run = true;
  Family& flow = add("flow_halved", TruthKind::flow);
  limit(flow, {{Measure::open_loop, 0.25}}, 0.95, 0.70);

  add("coolant_blocked", TruthKind::blocked);
  add("coolant_blocked_3", TruthKind::blocked).sensors = rear_sensors;

  for (const auto& [name, lag_s, most] : {std::tuple{"lag_5s", 5.0, 1.1}, std::tuple{"lag_30s", 30.0, 1.5}}) {
    Family& lag = add(name);
    lag.lag_s = lag_s;
    lag.must_run = true;
    limit(lag, {{Measure::nominal, most}}, 0.95, 0.80);
  }
  Family& known = add("gaps_known");
  known.gaps = Gaps::signals_known;
  known.must_run = true;
  limit(known, {{Measure::nominal, 1.1}}, 0.95);
  Family& held = add("gaps_held");
  held.gaps = Gaps::signals_held;
  held.must_run = true;
  limit(held, {{Measure::nominal, 2.0}}, 0.90);

  Family& cutting = add("nose_25W", TruthKind::cutting);
  limit(cutting, {{Measure::present, 1.0}}, 0.70);
  Family& touched = add("nose_25W_touched", TruthKind::cutting);
  touched.touch_offs = true;
  limit(touched, {{Measure::present, 0.5}}, 0.90);

  limit(add("structure_10", TruthKind::structure_10), {{Measure::present, 1.0}}, 0.95);
  add("structure_10_20", TruthKind::structure);
  add("contact_missing", TruthKind::contact);

  const auto wrong = [&](const char* name) -> Family& {
    Family& family = add(name);
    limit(family, {{Measure::present, 1.0}, {Measure::open_loop, 1.1}}, 0.90, 0.60);
    return family;
  };
  wrong("winding_drifts").winding_drift_K_per_h = 0.5;
  wrong("untared").offset_K = 0.2;
  wrong("exchanged").exchanged = true;
  wrong("speed_1.1").speed_scale = 1.1;
  wrong("key_points_10mm").displaced = true;

  Family& fast = add("sampled_0.1s");
  fast.cycle_s = 0.1;
  fast.run_s = 2400.0;
  fast.most_runs = 4;
  add("sampled_1s").cycle_s = 1.0;
  add("sampled_10s").cycle_s = 10.0;
  for (std::size_t i = families.size() - 3; i < families.size(); ++i) {
    families[i].inside_priors = families[i].must_run = true;
  }
  Family& told = add("inlet_step_told", TruthKind::inlet);
  told.inside_priors = told.must_run = true;
  add("inlet_step_untold", TruthKind::inlet).inlet_untold = true;
  add("grease_peak", TruthKind::grease);
  add("run_in", TruthKind::run_in);
  return families;
}

}  // namespace

bool Family::is_faulty(std::size_t sensor) const {
  return (winding_drift_K_per_h != 0.0 && sensor == winding) ||
         (exchanged && (sensor == front_seat || sensor == jacket));
}

const std::vector<Family>& all_families() {
  static const std::vector<Family> families = make_families();
  return families;
}

const Family& nominal_family() { return all_families().front(); }

}  // namespace spindle_twin::bench

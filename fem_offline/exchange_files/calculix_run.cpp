#include "fem_offline/exchange_files/calculix_run.hpp"

#include <cmath>
#include <filesystem>

#include "fem_offline/exchange_files/deck_files.hpp"

namespace spindle_twin::fem_offline {

std::vector<TimeStage> time_stages(const DeckPlan& plan) {
  std::vector<TimeStage> stages;
  double from_s = 0.0;
  for (const double until_s : plan.output_times_s) {
    const double wanted_s = from_s < 60.0 ? 2.0 : from_s < 300.0 ? 6.0 : from_s < 900.0 ? 20.0 : 45.0;
    const double pairs = std::ceil(0.5 * (until_s - from_s) / wanted_s);
    stages.push_back({until_s, 0.5 * (until_s - from_s) / pairs});
    from_s = until_s;
  }
  return stages;
}

void write_calculix_run(std::size_t nodes, bool with_growth, const std::string& directory) {
  DeckFile file(directory, "run");
  file << R"sh(#!/bin/bash
# Runs all analyses of this folder. Temperatures of all nodes: *_temperatures_<step>.inc, displacements: growth_*.dat,
# processor time of each thermal analysis: *.seconds.
set -euo pipefail
cd "$(dirname "$0")"
TIMEFORMAT='%U'
for deck in steady transient transient_double; do
  { time ccx "$deck" >"$deck.log" 2>&1; } 2>"$deck.seconds" || { tail -n 20 "$deck.log" >&2; exit 1; }
done
read_temperatures='FNR == 1 { file++; step = 0 } /temperatures/ { step++ }
  NF == 2 && $1 + 0 > 0 && $1 + 0 <= last {
    if (file < files) coarse[step, $1] = $2
    else printf "%d, %.7f\n", $1, (files == 2 ? 2 * $2 - coarse[step, $1] : $2) > (name "_temperatures_" step ".inc")
  }'
)sh"
       << "last=" << nodes << R"sh(
awk -v last="$last" -v files=1 -v name=steady "$read_temperatures" steady.dat
awk -v last="$last" -v files=2 -v name=transient "$read_temperatures" transient_double.dat transient.dat
)sh";
  if (with_growth) {
    file << R"sh(for deck in growth_*.inp; do
  ccx "${deck%.inp}" >"${deck%.inp}.log" 2>&1 || { tail -n 20 "${deck%.inp}.log" >&2; exit 1; }
done
)sh";
  }
  file.close();
  using Permissions = std::filesystem::perms;
  std::filesystem::permissions(directory + "/run", Permissions::owner_exec | Permissions::group_exec,
                               std::filesystem::perm_options::add);
}

}  // namespace spindle_twin::fem_offline

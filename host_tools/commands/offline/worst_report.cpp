#include "host_tools/commands/offline/worst_report.hpp"

#include <fmt/core.h>

#include <cstdio>

#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Json = nlohmann::ordered_json;

std::string state_text(const rom::OperatingState& state, const rom::Boundaries& boundaries) {
  std::string text = fmt::format("{:.0f} rpm, load {:.2f}", state.speed_rpm, state.load);
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    text += fmt::format(", {} {:.1f} degC", boundaries.environments[e].name,
                        state.environment_K[static_cast<Eigen::Index>(e)] - rom::zero_degC_K);
  }
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    text +=
        fmt::format(", {} {:.3g} kg/s", boundaries.circuits[c].name, state.flow_kg_per_s[static_cast<Eigen::Index>(c)]);
  }
  return text;
}

Json state_json(const rom::OperatingState& state, const rom::Boundaries& boundaries) {
  Json json = {{"speed_rpm", state.speed_rpm}, {"load", state.load}};
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    json[boundaries.environments[e].name + "_degC"] =
        state.environment_K[static_cast<Eigen::Index>(e)] - rom::zero_degC_K;
  }
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    json[boundaries.circuits[c].name + "_kg_per_s"] = state.flow_kg_per_s[static_cast<Eigen::Index>(c)];
  }
  return json;
}

Json kind_json(const fem_offline::WorstFound::Kind& kind, const char* unit, const rom::Boundaries& boundaries) {
  Json json = {{"error", kind.error}, {"unit", unit}, {"output", kind.output}};
  if (kind.output.empty()) return json;
  if (kind.jump.uniform_start_K) {
    json["before"]["uniform_degC"] = *kind.jump.uniform_start_K - rom::zero_degC_K;
  } else {
    json["before"] = state_json(kind.jump.before, boundaries);
  }
  json["after"] = state_json(kind.jump.after, boundaries);
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    json["factors"][boundaries.conductances[j].name] = kind.jump.factors.conductance[static_cast<Eigen::Index>(j)];
  }
  return json;
}

}  // namespace

void print_worst_found(const fem_offline::WorstFound& found, const rom::Boundaries& boundaries) {
  std::printf("  worst found by a search through %d jumps, %.0f s each\n", found.cases, fem_offline::worst_search_s);
  const auto print = [&](const char* what, const fem_offline::WorstFound::Kind& kind) {
    if (kind.output.empty()) return;
    std::printf("  %-24s %-32s %11.4f\n", what, kind.output.c_str(), kind.error);
    const std::string start = kind.jump.uniform_start_K
                                  ? fmt::format("all at {:.1f} degC", *kind.jump.uniform_start_K - rom::zero_degC_K)
                                  : "steady state of " + state_text(kind.jump.before, boundaries);
    std::printf("    from %s\n    to   %s\n", start.c_str(), state_text(kind.jump.after, boundaries).c_str());
  };
  print("key point, K", found.key_points);
  print("deformation, um", found.nose);
  print("part maximum, K", found.part_maxima);
}

Json worst_found_json(const fem_offline::WorstFound& found, const rom::Boundaries& boundaries) {
  return {{"searched", found.cases},
          {"key_point", kind_json(found.key_points, "K", boundaries)},
          {"nose", kind_json(found.nose, "um", boundaries)},
          {"part_max", kind_json(found.part_maxima, "K", boundaries)}};
}

}  // namespace spindle_twin::host_tools

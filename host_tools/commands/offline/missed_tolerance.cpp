#include "host_tools/commands/offline/missed_tolerance.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "host_tools/commands/offline/accuracy_options.hpp"

namespace spindle_twin::host_tools {
namespace {

using fem_offline::MissedOutput;

constexpr std::size_t most_named = 6;

const char* unit_of(MissedOutput::Kind kind) { return kind == MissedOutput::Kind::deformation ? "um" : "K"; }

std::string output_of(const MissedOutput& missed) {
  switch (missed.kind) {
    case MissedOutput::Kind::key_point:
      return "key point " + missed.name;
    case MissedOutput::Kind::deformation:
      return "deformation " + missed.name;
    case MissedOutput::Kind::part_maximum:
      return "maximum of " + missed.name;
  }
  return missed.name;
}

/// Up to two digits, not below `value`.
double rounded_up(double value) {
  const double digit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::ceil(value / digit - 1e-9) * digit;
}

}  // namespace

std::string kept_tolerance(const fem_offline::SizeChoice& choice, const fem_offline::Tolerance& tolerance) {
  fem_offline::Tolerance kept = tolerance;
  for (const MissedOutput& missed : choice.missed) {
    double& of_kind = missed.kind == MissedOutput::Kind::key_point     ? kept.key_points_K
                      : missed.kind == MissedOutput::Kind::deformation ? kept.deformations_um
                                                                       : kept.part_max_K;
    of_kind = std::max(of_kind, rounded_up(missed.worst / fem_offline::share_of_tolerance));
  }
  return fmt::format("{:.3g}K,{:.3g}um,{:.3g}K", kept.key_points_K, kept.deformations_um, kept.part_max_K);
}

std::string missed_tolerance_text(const fem_offline::SizeChoice& choice, const fem_offline::Tolerance& tolerance,
                                  const std::string& box) {
  std::string text = fmt::format(
      "the tolerance {:.3g}K,{:.3g}um,{:.3g}K is not kept with the search's margin ({:g} of it):",
      tolerance.key_points_K, tolerance.deformations_um, tolerance.part_max_K, fem_offline::share_of_tolerance);
  for (std::size_t i = 0; i < std::min(most_named, choice.missed.size()); ++i) {
    const MissedOutput& missed = choice.missed[i];
    text += fmt::format("\n  {:<36} errs by {:.3g} {} in the worst case, wanted {:.3g} {}", output_of(missed),
                        missed.worst, unit_of(missed.kind), missed.wanted, unit_of(missed.kind));
  }
  if (choice.missed.size() > most_named) text += fmt::format("\n  and {} more", choice.missed.size() - most_named);
  text += "\nwhat helps:";
  if (choice.nodes_likely_enough > 0 && choice.nodes_likely_enough <= most_nodes) {
    text += fmt::format("\n  --nodes {}, by the usual fall of errors with the size", choice.nodes_likely_enough);
  }
  text += fmt::format("\n  --tolerance {}, which {} nodes keep", kept_tolerance(choice, tolerance),
                      choice.network.nodes.size());
  if (box == "whole") {
    text += "\n  --box small, where contacts are known to 0.3 to 3 times and films to 0.5 to 2 times";
  }
  return text;
}

nlohmann::ordered_json missed_tolerance_json(const fem_offline::SizeChoice& choice) {
  nlohmann::ordered_json result = {{"kept", choice.reached}};
  if (choice.reached) return result;
  result["nodes_likely_enough"] = choice.nodes_likely_enough;
  for (const MissedOutput& missed : choice.missed) {
    result["missed"].push_back({{"output", output_of(missed)},
                                {"worst", missed.worst},
                                {"wanted", missed.wanted},
                                {"unit", unit_of(missed.kind)}});
  }
  return result;
}

}  // namespace spindle_twin::host_tools

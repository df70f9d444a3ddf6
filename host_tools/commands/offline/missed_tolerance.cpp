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

std::string written(const fem_offline::Tolerance& tolerance) {
  return fmt::format("{:.3g}K,{:.3g}um,{:.3g}K", tolerance.key_points_K, tolerance.deformations_um,
                     tolerance.part_max_K);
}

std::string misses_text(const ToleranceVerdict& verdict) {
  std::string text =
      verdict.limiting_cases > 0
          ? fmt::format("limits of its certificate ({} cases) exceed the tolerance {}:", verdict.limiting_cases,
                        written(verdict.tolerance))
          : fmt::format("the tolerance {} is not kept with the search's margin ({:g} of it):",
                        written(verdict.tolerance), fem_offline::share_of_tolerance);
  const char* error = verdict.limiting_cases > 0 ? "limit" : "errs by";
  for (std::size_t i = 0; i < std::min(most_named, verdict.missed.size()); ++i) {
    const MissedOutput& missed = verdict.missed[i];
    text += fmt::format("\n  {:<36} {} {:.3g} {}, wanted {:.3g} {}", output_of(missed), error, missed.error,
                        unit_of(missed.kind), missed.wanted, unit_of(missed.kind));
  }
  if (verdict.missed.size() > most_named) text += fmt::format("\n  and {} more", verdict.missed.size() - most_named);
  return text;
}

int nodes_likely_enough(const ToleranceVerdict& verdict) {
  return verdict.larger_possible ? fem_offline::nodes_likely_enough(verdict.nodes, verdict.missed) : 0;
}

}  // namespace

ToleranceVerdict judge_tolerance(const fem_offline::SizeChoice& choice, const fem_offline::AffineModel& model,
                                 const rom::Certificate& certificate, const fem_offline::Tolerance& tolerance) {
  ToleranceVerdict verdict;
  verdict.tolerance = tolerance;
  verdict.nodes = static_cast<int>(choice.network.nodes.size());
  verdict.margin_kept = choice.reached;
  verdict.larger_possible = choice.larger_possible;
  if (certificate.limit_rule.content > 0.0) {
    verdict.limiting_cases = static_cast<int>(certificate.cases);
    verdict.missed = fem_offline::missed_limits(model, certificate, tolerance);
  } else {
    verdict.missed = choice.missed;
  }
  return verdict;
}

std::string kept_tolerance(const ToleranceVerdict& verdict) {
  const double share = verdict.limiting_cases > 0 ? 1.0 : fem_offline::share_of_tolerance;
  fem_offline::Tolerance kept = verdict.tolerance;
  for (const MissedOutput& missed : verdict.missed) {
    double& of_kind = missed.kind == MissedOutput::Kind::key_point     ? kept.key_points_K
                      : missed.kind == MissedOutput::Kind::deformation ? kept.deformations_um
                                                                       : kept.part_max_K;
    of_kind = std::max(of_kind, rounded_up(missed.error / share));
  }
  return written(kept);
}

std::string tolerance_text(const ToleranceVerdict& verdict, const std::string& box) {
  if (verdict.kept()) {
    if (verdict.margin_kept) return {};
    return fmt::format(
        "the limits of its certificate ({} cases) keep the tolerance {}, though none of the sizes tried "
        "keeps it with the search's margin ({:g} of it)",
        verdict.limiting_cases, written(verdict.tolerance), fem_offline::share_of_tolerance);
  }
  std::string text = misses_text(verdict) + "\nwhat helps:";
  if (const int nodes = nodes_likely_enough(verdict); nodes > 0 && nodes <= most_nodes) {
    text += fmt::format("\n  --nodes {}, by the usual fall of errors with the size", nodes);
  }
  text += fmt::format("\n  --tolerance {}, which {} nodes keep", kept_tolerance(verdict), verdict.nodes);
  if (box == "whole") {
    text += "\n  --box small, where contacts are known to 0.3 to 3 times and films to 0.5 to 2 times";
  }
  return text;
}

nlohmann::ordered_json tolerance_json(const ToleranceVerdict& verdict) {
  nlohmann::ordered_json result = {{"kept", verdict.kept()},
                                   {"judged_by", verdict.limiting_cases > 0 ? "certificate" : "search"},
                                   {"margin_kept", verdict.margin_kept}};
  if (verdict.kept()) return result;
  result["nodes_likely_enough"] = nodes_likely_enough(verdict);
  for (const MissedOutput& missed : verdict.missed) {
    result["missed"].push_back({{"output", output_of(missed)},
                                {"error", missed.error},
                                {"wanted", missed.wanted},
                                {"unit", unit_of(missed.kind)}});
  }
  return result;
}

}  // namespace spindle_twin::host_tools

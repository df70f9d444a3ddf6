#include "firmware/show/factor_json.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "firmware/show/json_text.hpp"

namespace spindle_twin::firmware {
namespace {

std::string number(float value) { return std::isfinite(value) ? fmt::format("{:.4f}", value) : "null"; }

std::string bands(const std::vector<std::string>& names, std::span<const FactorBand> of) {
  std::string json;
  for (std::size_t i = 0; i < std::min(names.size(), of.size()); ++i) {
    json += fmt::format("{}{}:{{\"prior_ln_mean\":{},\"prior_ln_sd\":{},\"ln_sd\":{}}}", json.empty() ? "" : ",",
                        json_text(names[i]), number(of[i].prior_mean), number(of[i].prior_deviation),
                        number(of[i].deviation));
  }
  return json;
}

}  // namespace

std::string factors_json(const Snapshot& snapshot, const ShownNames& names) {
  return fmt::format("\"factors\":{{\"heat\":{{{}}},\"conductance\":{{{}}}}}", bands(names.sources, snapshot.heat_band),
                     bands(names.conductances, snapshot.conductance_band));
}

}  // namespace spindle_twin::firmware

#include "firmware/keep/parameters.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>

namespace spindle_twin::firmware {

std::string parameters_csv(const std::vector<correction::Parameter>& parameters,
                           const std::vector<correction::ParameterEstimate>& estimates) {
  std::string text = "parameter,value,deviation,prior,prior_deviation,determined\n";
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const correction::ParameterEstimate& estimate = estimates[i];
    text += fmt::format("{},{:.6g},{:.6g},{:.6g},{:.6g},{}\n", parameters[i].name, estimate.value, estimate.deviation,
                        parameters[i].mean, estimate.prior_deviation, estimate.undetermined() ? 0 : 1);
  }
  return text;
}

std::string what_is_determined(const std::vector<correction::Parameter>& parameters,
                               const std::vector<correction::ParameterEstimate>& estimates) {
  std::string known;
  std::string open;
  std::size_t count = 0;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    std::string& list = estimates[i].undetermined() ? open : known;
    list.append(list.empty() ? "" : ", ").append(parameters[i].name);
    if (!estimates[i].undetermined()) ++count;
  }
  if (count == 0) return fmt::format("the sensors determine none of {} parameters", parameters.size());
  if (open.empty()) return fmt::format("the sensors determine all {} parameters", count);
  return fmt::format("the sensors determine {} of {} parameters ({}) and say nothing of the others ({})", count,
                     parameters.size(), known, open);
}

std::string unexplained_heats(const std::vector<correction::Parameter>& parameters,
                              const std::vector<correction::ParameterEstimate>& estimates) {
  std::string heats;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const correction::ParameterEstimate& estimate = estimates[i];
    if (parameters[i].kind != correction::ParameterKind::disturbance || estimate.shut) continue;
    if (!(std::abs(estimate.value) > correction::ParameterEstimate::significant * estimate.deviation)) continue;
    heats += fmt::format("{}{}: {:.0f} W +- {:.0f} W", heats.empty() ? "" : ", ", parameters[i].name, estimate.value,
                         estimate.deviation);
  }
  return heats.empty() ? heats : "the readings ask for heat that no source explains (" + heats + ")";
}

}  // namespace spindle_twin::firmware

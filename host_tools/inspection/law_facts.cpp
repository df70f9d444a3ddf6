#include "host_tools/inspection/law_facts.hpp"

#include <utility>

#include "rom/laws/law_fields.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

/// Name of the part or environment, empty where the temperature is a constant.
std::string place_of(const rom::Network& network, const rom::LawTemperature& temperature) {
  if (temperature.part >= 0) return network.parts[static_cast<std::size_t>(temperature.part)].name;
  if (temperature.environment < 0) return "";
  return network.boundaries.environments[static_cast<std::size_t>(temperature.environment)].name;
}

}  // namespace

std::string law_words(const rom::Network& network, const rom::BoundLaw& law) {
  std::string words(rom::traits_of(law.law).kind);
  std::string reads;
  const auto add = [&](const std::string& name) {
    if (!name.empty()) reads.append(reads.empty() ? " of " : ", ").append(name);
  };
  add(place_of(network, law.first));
  add(place_of(network, law.second));
  if (law.pressure >= 0) add(network.contact_pressures[static_cast<std::size_t>(law.pressure)].name);
  if (law.displacement >= 0) add(network.deformations[static_cast<std::size_t>(law.displacement)].name);
  if (law.law.mode != rom::LawMode::standard) {
    words.append(" (").append(rom::law_modes[static_cast<std::size_t>(law.law.mode)]).append(")");
  }
  return words + reads;
}

nlohmann::json law_json(const rom::Network& network, const rom::BoundLaw& law) {
  nlohmann::json json{{"kind", std::string(rom::traits_of(law.law).kind)},
                      {"mode", std::string(rom::law_modes[static_cast<std::size_t>(law.law.mode)])},
                      {"numbers", nlohmann::json::object()}};
  const rom::LawTemperatureNames& names = rom::traits_of(law.law).temperatures;
  for (const auto& [word, temperature] : {std::pair{names.first, law.first}, {names.second, law.second}}) {
    if (word.empty()) continue;
    const std::string key(word);
    if (const std::string place = place_of(network, temperature); !place.empty()) json[key] = place;
    if (temperature.environment < 0) json[key + "_degC"] = temperature.nominal_K - rom::zero_degC_K;
  }
  if (law.pressure >= 0) {
    json["pressure"] = network.contact_pressures[static_cast<std::size_t>(law.pressure)].name;
  }
  if (law.displacement >= 0) {
    json[law.displacement_sign < 0.0 ? "opening" : "closing"] =
        network.deformations[static_cast<std::size_t>(law.displacement)].name;
  }
  for (const rom::NamedNumber& number : rom::law_numbers(law.law.parameters))
    json["numbers"][number.name] = number.value;
  return json;
}

}  // namespace spindle_twin::host_tools

#include <array>
#include <cstdio>
#include <pugixml.hpp>
#include <sstream>
#include <utility>

#include "host_tools/fmu/variables.hpp"
#include "host_tools/fmu/write_fmu.hpp"

namespace spindle_twin::host_tools {
namespace {

std::string exact(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

void set(pugi::xml_node node, const char* attribute, const std::string& value) {
  node.append_attribute(attribute).set_value(value.c_str());
}

pugi::xml_node add_unit(pugi::xml_node units, const char* name) {
  pugi::xml_node unit = units.append_child("Unit");
  set(unit, "name", name);
  return unit;
}

/// Every unit by its exponents of SI base units, as the standard has it.
void add_units(pugi::xml_node root) {
  pugi::xml_node units = root.append_child("UnitDefinitions");
  const auto base = [](pugi::xml_node unit, std::initializer_list<std::pair<const char*, const char*>> exponents) {
    pugi::xml_node node = unit.append_child("BaseUnit");
    for (const auto& [name, exponent] : exponents) set(node, name, exponent);
  };
  const auto display = [](pugi::xml_node unit, const char* name, const char* factor, const char* offset) {
    pugi::xml_node node = unit.append_child("DisplayUnit");
    set(node, "name", name);
    if (factor != nullptr) set(node, "factor", factor);
    if (offset != nullptr) set(node, "offset", offset);
  };
  pugi::xml_node kelvin = add_unit(units, "K");
  base(kelvin, {{"K", "1"}});
  display(kelvin, "degC", nullptr, "-273.15");
  pugi::xml_node metre = add_unit(units, "m");
  base(metre, {{"m", "1"}});
  display(metre, "um", "1e6", nullptr);
  pugi::xml_node pascal = add_unit(units, "Pa");
  base(pascal, {{"kg", "1"}, {"m", "-1"}, {"s", "-2"}});
  display(pascal, "MPa", "1e-6", nullptr);
  base(add_unit(units, "W"), {{"kg", "1"}, {"m", "2"}, {"s", "-3"}});
  base(add_unit(units, "kg/s"), {{"kg", "1"}, {"s", "-1"}});
  base(add_unit(units, "rpm"), {{"s", "-1"}, {"rad", "1"}, {"factor", "0.10471975511965977"}});
}

void add_variable(pugi::xml_node list, const FmuVariable& item, std::size_t reference) {
  pugi::xml_node variable = list.append_child("ScalarVariable");
  set(variable, "name", item.name);
  set(variable, "valueReference", std::to_string(reference));
  set(variable, "description", item.description);
  switch (item.role) {
    case FmuRole::input:
      set(variable, "causality", "input");
      set(variable, "variability", "continuous");
      break;
    case FmuRole::fixed_parameter:
      set(variable, "causality", "parameter");
      set(variable, "variability", "fixed");
      set(variable, "initial", "exact");
      break;
    case FmuRole::tunable_parameter:
      set(variable, "causality", "parameter");
      set(variable, "variability", "tunable");
      set(variable, "initial", "exact");
      break;
    case FmuRole::output:
      set(variable, "causality", "output");
      set(variable, "variability", "continuous");
      set(variable, "initial", "calculated");
      break;
  }
  pugi::xml_node real = variable.append_child("Real");
  if (!item.unit.empty()) set(real, "unit", item.unit);
  if (item.unit == "K") set(real, "displayUnit", "degC");
  if (item.unit == "m") set(real, "displayUnit", "um");
  if (item.unit == "Pa") set(real, "displayUnit", "MPa");
  if (item.role != FmuRole::output) set(real, "start", exact(item.start));
  if (item.role == FmuRole::tunable_parameter) set(real, "min", "0");
}

void add_unknowns(pugi::xml_node structure, const char* list, const std::vector<FmuVariable>& variables) {
  pugi::xml_node unknowns = structure.append_child(list);
  for (std::size_t i = 0; i < variables.size(); ++i) {
    if (variables[i].role == FmuRole::output) set(unknowns.append_child("Unknown"), "index", std::to_string(i + 1));
  }
}

}  // namespace

std::string fmu_model_description(const rom::Network& network, const std::string& guid) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  set(declaration, "version", "1.0");
  set(declaration, "encoding", "UTF-8");
  pugi::xml_node root = document.append_child("fmiModelDescription");
  set(root, "fmiVersion", "2.0");
  set(root, "modelName", network.spindle);
  set(root, "guid", guid);
  set(root, "description",
      std::string("Thermal network of a spindle, description SHA-256 ").append(network.description_hash));
  set(root, "generationTool", "spindle-twin");
  set(root, "variableNamingConvention", "flat");

  pugi::xml_node slave = root.append_child("CoSimulation");
  set(slave, "modelIdentifier", "spindle_twin");
  set(slave, "canHandleVariableCommunicationStepSize", "true");
  set(slave, "canGetAndSetFMUstate", "true");
  set(slave, "canSerializeFMUstate", "true");
  add_units(root);
  set(root.append_child("LogCategories").append_child("Category"), "name", "logStatusError");
  pugi::xml_node experiment = root.append_child("DefaultExperiment");
  set(experiment, "startTime", "0");
  set(experiment, "stopTime", "3600");
  set(experiment, "stepSize", "1");

  const std::vector<FmuVariable> variables = fmu_variables(network);
  pugi::xml_node list = root.append_child("ModelVariables");
  for (std::size_t i = 0; i < variables.size(); ++i) add_variable(list, variables[i], i);
  pugi::xml_node structure = root.append_child("ModelStructure");
  add_unknowns(structure, "Outputs", variables);
  add_unknowns(structure, "InitialUnknowns", variables);

  std::ostringstream text;
  document.save(text, " ");
  return text.str();
}

}  // namespace spindle_twin::host_tools

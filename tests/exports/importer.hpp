#pragma once

#include <map>
#include <string>
#include <vector>

#include "host_tools/fmu/fmi2.hpp"

namespace spindle_twin::host_tools::tests {

/// A small importer of FMI 2.0 co-simulation FMUs: unpacks with libzip, reads modelDescription.xml with pugixml, loads
/// the binary with dlopen, and calls it by the standard's names.
struct Importer {
  explicit Importer(const std::string& fmu_path);
  ~Importer();
  Importer(const Importer&) = delete;
  Importer& operator=(const Importer&) = delete;

  fmi2Component instantiate(const std::string& name) {
    return instantiate(name, guid, "file://" + folder + "/resources");
  }
  fmi2Component instantiate(const std::string& name, const std::string& with_guid, const std::string& resources);
  double get(fmi2Component slave, const std::string& variable);
  fmi2Status set(fmi2Component slave, const std::string& variable, double value);

  template <class Function>
  Function* function(Function*, const char* name) const {
    return reinterpret_cast<Function*>(symbol(name));
  }
  void* symbol(const char* name) const;

  std::string folder;
  std::string guid;
  std::map<std::string, fmi2ValueReference> references;
  std::map<std::string, std::string> units;
  std::map<std::string, double> starts;
  std::vector<std::string> outputs;   ///< by ModelStructure
  std::vector<std::string> messages;  ///< what the slaves logged
  fmi2CallbackFunctions callbacks{};

 private:
  void* library_ = nullptr;
};

#define FMI2_CALL(importer, name) (importer).function(static_cast<decltype(&name)>(nullptr), #name)

}  // namespace spindle_twin::host_tools::tests

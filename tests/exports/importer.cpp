#include "tests/exports/importer.hpp"

#include <dlfcn.h>
#include <stdlib.h>
#include <zip.h>

#include <cstdarg>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <pugixml.hpp>
#include <stdexcept>

namespace spindle_twin::host_tools::tests {
namespace {

void unpack(const std::string& archive_path, const std::string& folder) {
  zip_t* archive = zip_open(archive_path.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, nullptr);
  if (archive == nullptr) throw std::runtime_error("no zip archive: " + archive_path);
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive, 0); ++i) {
    zip_stat_t stat;
    zip_stat_index(archive, static_cast<zip_uint64_t>(i), 0, &stat);
    std::string bytes(stat.size, '\0');
    zip_file_t* file = zip_fopen_index(archive, static_cast<zip_uint64_t>(i), 0);
    if (file == nullptr || zip_fread(file, bytes.data(), bytes.size()) != static_cast<zip_int64_t>(bytes.size())) {
      throw std::runtime_error("damaged entry in " + archive_path);
    }
    zip_fclose(file);
    const std::filesystem::path path = std::filesystem::path(folder) / stat.name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << bytes;
  }
  zip_discard(archive);
}

void log(fmi2ComponentEnvironment environment, fmi2String, fmi2Status, fmi2String, fmi2String format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  static_cast<Importer*>(environment)->messages.emplace_back(text);
}

}  // namespace

Importer::Importer(const std::string& fmu_path) {
  std::string name = std::filesystem::temp_directory_path() / "fmu with blank.XXXXXX";
  folder = ::mkdtemp(name.data());
  unpack(fmu_path, folder);
  pugi::xml_document document;
  if (!document.load_file((folder + "/modelDescription.xml").c_str()))
    throw std::runtime_error("no modelDescription.xml");
  const pugi::xml_node root = document.child("fmiModelDescription");
  if (root.attribute("fmiVersion").as_string() != std::string("2.0")) throw std::runtime_error("not FMI 2.0");
  guid = root.attribute("guid").as_string();
  std::vector<std::string> names;
  for (const pugi::xml_node variable : root.child("ModelVariables").children("ScalarVariable")) {
    names.emplace_back(variable.attribute("name").as_string());
    references[names.back()] = variable.attribute("valueReference").as_uint();
    units[names.back()] = variable.child("Real").attribute("unit").as_string();
    if (const pugi::xml_attribute start = variable.child("Real").attribute("start")) {
      starts[names.back()] = start.as_double();
    }
  }
  for (const pugi::xml_node unknown : root.child("ModelStructure").child("Outputs").children("Unknown")) {
    outputs.push_back(names.at(unknown.attribute("index").as_uint() - 1));
  }
  const std::string identifier = root.child("CoSimulation").attribute("modelIdentifier").as_string();
  std::string binary;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder + "/binaries")) {
    if (entry.path().filename() == identifier + ".so") binary = entry.path();
  }
  library_ = ::dlopen(binary.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library_ == nullptr) throw std::runtime_error(::dlerror());
  callbacks = {log, ::calloc, ::free, nullptr, this};
}

Importer::~Importer() {
  if (library_ != nullptr) ::dlclose(library_);
  std::filesystem::remove_all(folder);
}

void* Importer::symbol(const char* name) const {
  void* found = ::dlsym(library_, name);
  if (found == nullptr) throw std::runtime_error(std::string("no function ") + name);
  return found;
}

fmi2Component Importer::instantiate(const std::string& name, const std::string& with_guid,
                                    const std::string& resources) {
  return FMI2_CALL(*this, fmi2Instantiate)(name.c_str(), fmi2CoSimulation, with_guid.c_str(), resources.c_str(),
                                           &callbacks, 0, 0);
}

double Importer::get(fmi2Component slave, const std::string& variable) {
  double value = 0.0;
  const fmi2ValueReference reference = references.at(variable);
  if (FMI2_CALL(*this, fmi2GetReal)(slave, &reference, 1, &value) != fmi2OK) {
    throw std::runtime_error("fmi2GetReal of " + variable);
  }
  return value;
}

fmi2Status Importer::set(fmi2Component slave, const std::string& variable, double value) {
  const fmi2ValueReference reference = references.at(variable);
  return FMI2_CALL(*this, fmi2SetReal)(slave, &reference, 1, &value);
}

}  // namespace spindle_twin::host_tools::tests

#include "host_tools/commands/kept_inputs.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/config/read_files.hpp"

namespace spindle_twin::host_tools {
namespace {

namespace fs = std::filesystem;

/// Options whose value is a file to write.
constexpr std::array<std::string_view, 6> writing_options{"output", "html", "csv", "spice", "fmu", "log"};

struct NamedFile {
  std::string option, path;
};

/// False where one is not there, or is no file: a device may be written by two.
bool is_file(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool are_one(const std::string& a, const std::string& b) {
  std::error_code error;
  if (is_file(a) && is_file(b)) return fs::equivalent(a, b, error);
  return firmware::one_way_to(a) == firmware::one_way_to(b) && !fs::exists(a, error);
}

}  // namespace

void keep_inputs(CLI::App& command) {
  std::vector<NamedFile> read, to_write;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_items_expected_max() == 0) continue;  // a flag
    const std::vector<std::string>& names = option->get_lnames();
    const bool writes = std::any_of(names.begin(), names.end(), [](const std::string& name) {
      return std::find(writing_options.begin(), writing_options.end(), name) != writing_options.end();
    });
    for (const std::string& value : option->results()) {
      if (!value.empty()) (writes ? to_write : read).push_back({option->get_name(), value});
    }
  }
  for (std::size_t i = 0; i < to_write.size(); ++i) {
    for (const NamedFile& input : read) {
      if (is_file(input.path) && are_one(to_write[i].path, input.path)) {
        throw CLI::ValidationError(to_write[i].option, to_write[i].path + " would be written over, and is read");
      }
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (are_one(to_write[i].path, to_write[k].path)) {
        throw CLI::ValidationError(
            to_write[i].option, to_write[i].path + " is also that of " + to_write[k].option + ": two files, not one");
      }
    }
  }
}

}  // namespace spindle_twin::host_tools

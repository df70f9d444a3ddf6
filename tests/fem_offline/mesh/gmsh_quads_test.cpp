#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "fem_offline/mesh/section_mesh.hpp"
#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace mesh_gmsh_quads_test {

/// A slanted plate on a slanted base, planar; `mesh` are the lines of [mesh].
Spindle plate_on_base(const std::string& mesh) {
  return parse_spindle(R"(name = "plates"
geometry = "planar"
[operating]
speed_rpm = 1000
reference_temperature_degC = 20
temperatures_degC = { room = 20 }
[mesh]
)" + mesh + R"(
)" + steel_text + R"([[part]]
name = "plate"
material = "steel"
polygons = [{ points = [[0, 0], [0, 100], [60, 110], [60, -5]] }]
[[part]]
name = "base"
material = "steel"
polygons = [{ points = [[-30, 5], [-30, 95], [0, 100], [0, 0]] }]
[[contact]]
between = ["plate", "base"]
conductance_W_per_m2K = 2000
[[surrounding]]
name = "room"
kind = "ambient"
[[film]]
name = "air"
coefficient_W_per_m2K = 10
surrounding = "room"
regions = [[-40, 70, -10, 120]]
)",
                       "plates.toml");
}

/// Sides of 0.28 mm: gmsh takes seconds for them.
const std::string many = "element_size_mm = 0.28\npart_time_limit_s = ";

std::string error_of(const Spindle& spindle) {
  try {
    mesh_section(spindle, build_section(spindle));
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "no error";
}

/// Processes whose parent this one is, from the fourth field of their stat; names in it may hold blanks.
std::vector<pid_t> children() {
  std::vector<pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream file(entry.path() / "stat");
    std::string text;
    std::getline(file, text);
    const std::size_t behind_name = text.rfind(')');
    if (behind_name == std::string::npos) continue;
    char state = 0;
    pid_t parent = 0;
    std::istringstream(text.substr(behind_name + 1)) >> state >> parent;
    if (parent == ::getpid()) found.push_back(static_cast<pid_t>(std::stol(name)));
  }
  return found;
}

TEST(GmshQuads, a_part_that_takes_too_long_is_one_error_that_names_it) {
  EXPECT_EQ(error_of(plate_on_base(many + "1")),
            "plates.toml:19: part.plate: gmsh could not mesh this part: it did not finish in 1 s of computing; raise "
            "element_size_mm or mesh.part_time_limit_s");
  EXPECT_TRUE(children().empty()) << "a process is left over";
}

TEST(GmshQuads, a_crash_of_gmsh_is_one_error_that_names_the_part) {
  std::atomic<bool> done{false};
  std::thread killer([&] {
    while (!done) {
      for (const pid_t child : children()) ::kill(child, SIGSEGV);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  const std::string error = error_of(plate_on_base(many + "60"));
  done = true;
  killer.join();
  EXPECT_EQ(error, "plates.toml:19: part.plate: gmsh could not mesh this part: it crashed (signal 11)");
  EXPECT_TRUE(children().empty()) << "a process is left over";
}

TEST(GmshQuads, a_time_limit_out_of_range_says_what_is_allowed) {
  try {
    plate_on_base("part_time_limit_s = 0");
    FAIL() << "accepted";
  } catch (const rom::InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "plates.toml:8: mesh.part_time_limit_s: must be an integer from 1 to 3600, is 0");
  }
}

}  // namespace mesh_gmsh_quads_test
}  // namespace spindle_twin::fem_offline

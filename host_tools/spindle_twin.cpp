#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <system_error>

#include "host_tools/commands/command_line.hpp"
#include "host_tools/commands/commands.hpp"

namespace spindle_twin::host_tools {
namespace {

#ifdef SPINDLE_TWIN_OFFLINE
/// Becomes the program with the offline commands: beside this one, as it is built, or in libexec, as it is installed.
/// Comes back only if neither can be started.
void become_offline_program(char** argv) {
  std::error_code none;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
  for (const char* place : {"spindle-twin-fem", "../libexec/spindle-twin-fem"}) {
    execv((here / place).c_str(), argv);
  }
  std::fprintf(stderr,
               "spindle-twin: warning: no spindle-twin-fem beside it nor in libexec: without offline commands\n");
}
#endif

}  // namespace
}  // namespace spindle_twin::host_tools

int main(int argc, char** argv) {
  using namespace spindle_twin::host_tools;
  return run_program(argc, argv, [&](CLI::App& app) {
    add_edge_commands(app);
#ifdef SPINDLE_TWIN_OFFLINE
    if (!can_answer(app, argc, argv)) become_offline_program(argv);
#endif
    add_export(app, nullptr);
  });
}

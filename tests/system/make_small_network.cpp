// Writes the small network of the daemon's tests as a .rom file: make_small_network OUT.rom
#include <cstdio>
#include <exception>

#include "rom/file/rom_file.hpp"
#include "tests/firmware/support/small_network.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    spindle_twin::rom::write_network(spindle_twin::tests::small_network(), argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}

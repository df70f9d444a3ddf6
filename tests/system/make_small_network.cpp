// Writes the small network of the daemon's tests as a .rom file: make_small_network OUT.rom [FACTOR]
// FACTOR multiplies all conductances; below zero the network is another spindle's.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "rom/file/rom_file.hpp"
#include "tests/firmware/support/small_network.hpp"

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return 2;
  try {
    spindle_twin::rom::Network network = spindle_twin::tests::small_network();
    const double factor = argc == 3 ? std::atof(argv[2]) : 1.0;
    if (factor < 0.0) network.spindle = "another";
    for (auto& conductance : network.boundaries.conductances) {
      conductance.nominal_W_per_m2K *= factor < 0.0 ? 1.0 : factor;
    }
    spindle_twin::rom::write_network(network, argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}

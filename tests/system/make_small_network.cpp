// Writes the small network of the daemon's tests as a .rom file: make_small_network OUT.rom [FACTOR|outlined]
// FACTOR multiplies all conductances; below zero the network is another spindle's. Outlined its parts have a shape.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "rom/file/rom_file.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace {

/// Rings one around the other, as rectangles of the meridian section.
void outline(spindle_twin::rom::Network& network) {
  double inner_m = 0.01;
  for (const auto& part : network.parts) {
    const double outer_m = inner_m + 0.02;
    Eigen::MatrixXd points_m(2, 4);
    points_m << inner_m, outer_m, outer_m, inner_m, 0.0, 0.0, 0.2, 0.2;
    network.outlines.push_back({part.name, points_m});
    inner_m = outer_m;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return 2;
  try {
    spindle_twin::rom::Network network = spindle_twin::tests::small_network();
    const std::string_view change = argc == 3 ? argv[2] : "1";
    if (change == "outlined") outline(network);
    const double factor = change == "outlined" ? 1.0 : std::atof(change.data());
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

#include "tests/bench/reality/twin.hpp"

#include <filesystem>

#include "fem_offline/reduce/mesh_error.hpp"
#include "fem_offline/reduce/verify.hpp"
#include "rom/file/rom_file.hpp"

namespace spindle_twin::bench {
namespace {

/// As `spindle-twin build` does it.
void certify(const TwinOptions& options, rom::Network& network) {
  const fem_offline::FeModel model = model_of(options.element_size_mm);
  fem_offline::VerifyOptions verify;
  verify.threads = options.threads;
  if (options.rough) verify.cases = 2;
  network.certificate = fem_offline::verify_network(network, model.affine(), verify).certificate;
  network.certificate.mesh_size_m = model.description().mesh.element_size_m;
  fem_offline::measure_mesh_error(model, {}, network.certificate);
}

}  // namespace

rom::Network certified_twin(const TwinOptions& options) {
  const std::string path =
      options.cache.empty() ? "" : options.cache + "/certified_" + std::to_string(options.nodes) + ".rom";
  if (!path.empty() && std::filesystem::exists(path)) return rom::read_network(path);
  rom::Network network = twin_network(options);
  certify(options, network);
  if (!path.empty()) rom::write_network(network, path);
  return network;
}

}  // namespace spindle_twin::bench

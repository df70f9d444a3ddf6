#include "tests/bench/campaign/models.hpp"

#include <algorithm>
#include <filesystem>

#include "fem_offline/reduce/reduce.hpp"
#include "rom/file/rom_file.hpp"

namespace spindle_twin::bench {
namespace {

fem_offline::Spindle described(double element_size_mm) {
  fem_offline::Spindle spindle =
      fem_offline::read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference.toml");
  spindle.mesh.element_size_m = 1e-3 * element_size_mm;
  const auto add = [&](const char* name, const char* part, double r_mm, double z_mm) {
    auto point = spindle.key_points.front();
    point.name = name;
    const auto found = std::find_if(spindle.parts.begin(), spindle.parts.end(),
                                    [&](const auto& candidate) { return candidate.name == part; });
    point.part = static_cast<int>(found - spindle.parts.begin());
    point.at = {1e-3 * r_mm, 1e-3 * z_mm};
    spindle.key_points.push_back(point);
  };
  add("front_seat", "front_seat", 52.0, 68.0);
  add("winding", "end_winding_front", 49.0, 150.0);
  add("jacket", "jacket", 62.0, 215.0);
  return spindle;
}

}  // namespace

fem_offline::FeModel model_of(double element_size_mm, const ChangeSpindle& change) {
  fem_offline::Spindle spindle = described(element_size_mm);
  if (change) change(spindle);
  return {spindle, fem_offline::build_section(spindle)};
}

void add_cutting_heat(fem_offline::Spindle& spindle, double heat_W) {
  const auto shaft = std::find_if(spindle.parts.begin(), spindle.parts.end(),
                                  [](const fem_offline::Part& part) { return part.name == "shaft"; });
  fem_offline::HeatShare share;
  share.part = static_cast<std::size_t>(shaft - spindle.parts.begin());
  share.on_face = fem_offline::Box{0.014, 0.042, 0.0, 0.0};
  fem_offline::HeatSource heat;
  heat.name = "cutting";
  heat.heat_W = heat_W;
  heat.shares.push_back(share);
  heat.where = spindle.heats.front().where;
  spindle.heats.push_back(heat);
}

rom::Network twin_network(const TwinOptions& options) {
  std::string path;
  if (!options.cache.empty()) {
    std::filesystem::create_directories(options.cache);
    path = options.cache + "/twin_" + std::to_string(options.nodes) + options.variant + ".rom";
    if (std::filesystem::exists(path)) return rom::read_network(path);
  }
  fem_offline::ReduceOptions reduce;
  reduce.nodes = options.nodes;
  if (options.rough) {
    reduce.full_sets = 16;
    reduce.full_histories = 16;
    reduce.rich_states = 240;
    reduce.rich_sets = 60;
  }
  reduce.threads = options.threads;
  rom::Network network = fem_offline::reduce_model(model_of(options.element_size_mm, options.change).affine(), reduce);
  if (!path.empty()) rom::write_network(network, path);
  return network;
}

void settle(CampaignOptions& options) {
  if (!options.is_short) return;
  options.runs = 1;
  options.twin.nodes = 80;
  options.twin.element_size_mm = 8.0;
  options.twin.rough = true;
  options.truth_mm = 10.0;
}

std::uint64_t seed_of(const CampaignOptions& options, int number, HeatErrors heats) {
  constexpr int first_common = 48;
  return 1000 * options.seed + static_cast<std::uint64_t>(number + (heats == HeatErrors::common ? first_common : 0));
}

}  // namespace spindle_twin::bench

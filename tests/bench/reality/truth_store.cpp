#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "tests/bench/reality/truth.hpp"

namespace spindle_twin::bench {
namespace {

constexpr int generation = 1;  // of what this program makes of a seed: one more and no old file is read

/// Raw numbers for this program on this computer.
template <class File, class Number>
void each_number(File& file, RealityTruth& truth, const Number& number) {
  number(file, truth.event_s);
  number(file, truth.inlet_step_K);
  for (TruthSample& sample : truth.samples) {
    for (double* value : {&sample.speed_rpm, &sample.load, &sample.coolant_K, &sample.ambient_K,
                          &sample.coolant_error_K, &sample.ambient_error_K, &sample.nose_m}) {
      number(file, *value);
    }
    for (double& place_K : sample.place_K) number(file, place_K);
  }
}

}  // namespace

TruthStore::TruthStore(std::string cache, double element_size_mm)
    : cache_(std::move(cache)),
      element_size_mm_(element_size_mm),
      described_(truth_model(TruthKind::nominal, 0, element_size_mm)) {
  if (!cache_.empty()) std::filesystem::create_directories(cache_);
}

std::string TruthStore::path_of(TruthKind kind, std::uint64_t seed) const {
  std::ostringstream path;
  path << cache_ << "/truth" << generation << '_' << element_size_mm_ << "mm_" << name_of(kind) << '_' << seed;
  return path.str();
}

RealityTruth TruthStore::get(TruthKind kind, std::uint64_t seed) const {
  if (!cache_.empty()) {
    std::ifstream file(path_of(kind, seed), std::ios::binary);
    RealityTruth truth;
    truth.kind = kind;
    truth.seed = seed;
    truth.samples.resize(static_cast<std::size_t>(followed_s / truth_sample_s) + 1);
    each_number(file, truth,
                [](std::ifstream& from, double& value) { from.read(reinterpret_cast<char*>(&value), sizeof value); });
    if (file) return truth;
  }
  const bool changed = kind == TruthKind::structure || kind == TruthKind::structure_10;
  std::optional<fem_offline::FeModel> own;
  if (changed) own.emplace(truth_model(kind, seed, element_size_mm_));
  RealityTruth truth = make_reality((own ? *own : described_).affine(), kind, seed);
  if (cache_.empty()) return truth;
  const std::string path = path_of(kind, seed);
  std::ostringstream part;
  part << path << ".part" << std::this_thread::get_id();
  std::ofstream file(part.str(), std::ios::binary);
  each_number(file, truth,
              [](std::ofstream& to, double& value) { to.write(reinterpret_cast<const char*>(&value), sizeof value); });
  file.close();
  if (file) std::filesystem::rename(part.str(), path);
  return truth;
}

}  // namespace spindle_twin::bench

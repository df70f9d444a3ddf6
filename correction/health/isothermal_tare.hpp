#pragma once

#include <cstdint>
#include <vector>

#include "rom/option.hpp"

namespace spindle_twin::correction {

/// When a machine counts as isothermal. All positive.
struct TareLimits {
  double rest_s = 7200.0;             ///< without heat
  double block_s = 300.0;             ///< readings are compared over two blocks of this length
  double rate_K_per_h = 0.3;          ///< of every sensor, between the blocks
  double spread_K = 1.0;              ///< largest minus smallest reading: untared class A sensors are within 0.2 K each
  double model_spread_K = 0.05;       ///< of the model's temperatures at the sensors
  double common_deviation_K = 0.015;  ///< 1σ by which places of a resting machine still differ

  /// Those that a person may set.
  template <class Options, class Visit>
  static void each(Options& limits, Visit&& visit) {
    constexpr rom::Range kelvin = rom::between(1e-3, 100.0);
    visit({"rest_s", "without speed and load", rom::between(60.0, 1e6)}, limits.rest_s);
    visit({"block_s", "two of these are compared", rom::between(10.0, 86400.0)}, limits.block_s);
    visit({"rate_K_per_h", "of every sensor", kelvin}, limits.rate_K_per_h);
    visit({"spread_K", "of the readings", kelvin}, limits.spread_K);
    visit({"model_spread_K", "of the model at the sensors", kelvin}, limits.model_spread_K);
  }
};

/// Offsets that were taken; plain numbers, for a checkpoint. reading − offset is what is used.
struct SensorTare {
  std::uint32_t count = 0;          ///< how often a tare was taken
  std::vector<double> offset_K;     ///< per channel; 0 where none was taken
  std::vector<double> deviation_K;  ///< 1σ; 0 where none was taken
};

/// What a tare that is not offered waits for: the first of these that is amiss.
enum class TareWait : std::uint8_t { nothing, heat, rest, change, apart, model, sensors };

/// Of a tare now. channel: the one that it waits for, -1 where it is no single one. left_s: until it is judged next;
/// NaN while there is heat.
struct TareOutlook {
  TareWait waits_for = TareWait::rest;
  int channel = -1;
  double left_s = 0.0;
};

struct TareSample {
  bool valid = false;
  double reading_K = 0.0;  ///< as read
  double model_K = 0.0;
};

/// In-situ tare. In a machine that has had no heat for long all sensors stand at one temperature, and what they differ
/// by is their offsets:
///   offered     no heat for rest_s, and over the last two blocks  |mean₂ − mean₁| / block_s <= rate,
///               max − min of the readings <= spread, of the model at the same places <= model_spread
///   offset_i    = (mean₁ + mean₂)_i / 2 − common,   common: mean over the valid sensors, or the ambient where one is
///   given σ²          = noise² / samples + common_deviation²
/// The common mean leaves the mean of all offsets unknown, which shifts all temperatures alike and hardly the growth;
/// an ambient that is measured better than σ / √sensors of the sensors sees that too. Nothing is taken by itself.
/// No allocation after construction; may run in the cycle.
class IsothermalTare {
 public:
  IsothermalTare(std::size_t channels, const TareLimits& limits);

  /// heated: the spindle turns, or has load.
  void step(const std::vector<TareSample>& samples, bool heated, double h_s);
  bool offered() const { return offered_; }
  /// Why it is not offered.
  TareOutlook outlook() const;
  /// False, and nothing changed, while it is not offered or fewer than two sensors are valid. ambient_K: NaN for the
  /// common mean.
  bool take(double ambient_K, double noise_K, SensorTare& tare) const;
  static void clear(SensorTare& tare);

 private:
  struct Block {
    std::vector<double> sum_K;
    std::vector<int> samples;
  };
  void begin(Block& block);
  double mean_K(const Block& block, std::size_t i) const { return block.sum_K[i] / block.samples[i]; }
  bool both(std::size_t i) const { return whole_ && earlier_.samples[i] > 0 && later_.samples[i] > 0; }
  double middle_K(std::size_t i) const { return 0.5 * (mean_K(earlier_, i) + mean_K(later_, i)); }
  void judge(const std::vector<TareSample>& samples);
  void judge_spread(const std::vector<TareSample>& samples);
  int furthest() const;

  TareLimits limits_;
  Block earlier_, later_, filling_;
  double rest_s_ = 0.0;
  double filled_s_ = 0.0;
  int blocks_ = 0;
  bool whole_ = false;
  bool offered_ = false;
  bool heated_ = false;
  TareWait judged_ = TareWait::rest;  ///< at the end of the last block
  int judged_channel_ = -1;
};

}  // namespace spindle_twin::correction

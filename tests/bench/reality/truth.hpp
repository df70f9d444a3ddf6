#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "fem_offline/model/build_model.hpp"

/// Virtual spindles that the estimator's priors do not contain: FE models with hidden factors, and with what no
/// parameter of the twin stands for. Nothing here asks the estimator, so that the same seeds give the same spindles
/// whatever becomes of it.
namespace spindle_twin::bench {

constexpr double followed_s = 7200.0;    ///< that a twin follows a truth
constexpr double truth_sample_s = 10.0;  ///< between samples of a truth
constexpr std::size_t sensor_count = 6;  ///< three at the rear sleeve, front seat, winding, jacket
constexpr std::size_t place_count = 18;  ///< the sensors' places, then each 10 mm forward and 10 mm backward
constexpr double inlet_step_size_K = 3.0;

/// What the spindle itself is and does; each kind is an FE run of its own.
enum class TruthKind {
  nominal,       ///< as in twin_campaign: heats, contacts, films, friction, inlets
  warm,          ///< runs an hour before the twin starts
  cold,          ///< runs an hour, then stands 20 to 40 min; the twin starts with the spindle
  flow,          ///< coolant flow halved at event_s
  blocked,       ///< the coolant stands from event_s on: its films at three hundredths
  cutting,       ///< 25 W into the shaft's front face from event_s on
  structure,     ///< conductivity, capacity, expansion of each material wrong by 10 to 20 %, each with its own sign
  structure_10,  ///< conductivity -10 %, capacity and expansion +10 % everywhere
  contact,       ///< one contact at a hundredth
  inlet,         ///< the coolant's inlet steps by 3 K at event_s
  grease,        ///< friction x 2.5 after each start, decaying within 20 min
  run_in         ///< friction x 1.5 at first, x 1 at the end
};

const char* name_of(TruthKind kind);

/// The state of machine and spindle at a sample.
struct TruthSample {
  double speed_rpm = 0.0;
  double load = 0.0;
  double coolant_K = 0.0;
  double ambient_K = 0.0;
  double coolant_error_K = 0.0;  ///< of what the machine tells
  double ambient_error_K = 0.0;
  double nose_m = 0.0;
  std::array<double, place_count> place_K{};
};

struct RealityTruth {
  TruthKind kind = TruthKind::nominal;
  std::uint64_t seed = 0;
  double event_s = -1.0;             ///< after the twin's start; -1: none
  double inlet_step_K = 0.0;         ///< of the coolant from event_s on
  std::vector<TruthSample> samples;  ///< every truth_sample_s from the twin's start on

  /// On straight lines between the samples.
  double nose_m(double time_s) const;
  double place_K(std::size_t place, double time_s) const;
  /// Speed, load and inlets are held from sample to sample.
  const TruthSample& held(double time_s) const;
};

/// Random numbers of a spindle for one purpose, independent of those for any other.
std::mt19937_64 random_of(std::uint64_t seed, std::uint32_t purpose);

/// The FE model of the truth: reference spindle with all places as key points and the cutting heat as its last source.
/// `seed` matters where the structure is wrong. May be called from several threads.
fem_offline::FeModel truth_model(TruthKind kind, std::uint64_t seed, double element_size_mm);

RealityTruth make_reality(const fem_offline::AffineModel& model, TruthKind kind, std::uint64_t seed);

/// Truths by kind and seed, kept in the folder `cache` (empty: not kept).
class TruthStore {
 public:
  TruthStore(std::string cache, double element_size_mm);
  /// May be called from several threads.
  RealityTruth get(TruthKind kind, std::uint64_t seed) const;

 private:
  std::string path_of(TruthKind kind, std::uint64_t seed) const;

  std::string cache_;
  double element_size_mm_;
  fem_offline::FeModel described_;  ///< where the structure is as described
};

}  // namespace spindle_twin::bench

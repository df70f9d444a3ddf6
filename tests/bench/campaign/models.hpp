#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "fem_offline/model/build_model.hpp"
#include "rom/network.hpp"
#include "tests/bench/campaign/campaign.hpp"
#include "tests/bench/in_parallel.hpp"

namespace spindle_twin::bench {

using ChangeSpindle = std::function<void(fem_offline::Spindle&)>;

/// The reference spindle with three more key points: front seat, winding, jacket; and changed by `change`.
fem_offline::FeModel model_of(double element_size_mm, const ChangeSpindle& change = {});

/// A heat "cutting" on the shaft's end face, at the nose, that no source of the reference spindle explains. [W]
void add_cutting_heat(fem_offline::Spindle& spindle, double heat_W);

struct TwinOptions {
  int nodes = 110;
  int threads = 2;
  double element_size_mm = 4.0;
  bool rough = false;         ///< few snapshots, for a quick look
  std::string cache;          ///< folder; empty: none
  std::string variant = {};   ///< name of the change in the cache
  ChangeSpindle change = {};  ///< of the description
};

/// The twin's network; kept in the cache.
rom::Network twin_network(const TwinOptions& options);

/// What every campaign may be told.
struct CampaignOptions {
  int runs = 0;
  std::uint64_t seed = 1;
  double truth_mm = 6.0;  ///< element size of the truth's FE model
  TwinOptions twin;
  bool is_short = false;
};

/// After parsing: coarse models and a single run where it is to be short.
void settle(CampaignOptions& options);

/// Seed of the number-th virtual spindle: the same ones whatever the number of runs, and others for A than for B.
std::uint64_t seed_of(const CampaignOptions& options, int number, HeatErrors heats);

}  // namespace spindle_twin::bench

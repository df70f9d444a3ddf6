#pragma once

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "fem_offline/model/build_model.hpp"
#include "rom/network.hpp"

namespace spindle_twin::bench {

/// The reference spindle with three more key points: front seat, winding, jacket.
fem_offline::FeModel model_of(double element_size_mm);

struct TwinOptions {
  int nodes = 110;
  int threads = 2;
  double element_size_mm = 4.0;
  std::string cache;  ///< folder; empty: none
};

/// The twin's network; kept in the cache.
rom::Network twin_network(const TwinOptions& options);

/// Calls work(i) for i in [0, count) from several threads.
template <class Work>
void in_parallel(int threads, int count, const Work& work) {
  std::atomic<int> next = 0;
  std::vector<std::jthread> pool;
  for (int t = 0; t < threads; ++t) {
    pool.emplace_back([&] {
      for (int i = next++; i < count; i = next++) work(i);
    });
  }
}

}  // namespace spindle_twin::bench

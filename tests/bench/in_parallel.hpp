#pragma once

#include <atomic>
#include <thread>
#include <vector>

namespace spindle_twin::bench {

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

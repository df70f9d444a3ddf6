#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace spindle_twin::fem_offline {

/// Calls body(index, worker) once for every index below count on up to `threads` workers; the first exception is
/// rethrown here. Which worker takes which index is left open: results stay the same for any number of threads only
/// if every index writes to a place of its own.
template <typename Body>
void for_each_index(int count, int threads, const Body& body) {
  std::atomic<int> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&](int worker) {
    for (int index = next++; index < count; index = next++) {
      try {
        body(index, worker);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  const int workers = std::clamp(threads, 1, std::max(count, 1));
  std::vector<std::jthread> helpers;
  for (int worker = 1; worker < workers; ++worker) helpers.emplace_back(work, worker);
  work(0);
  helpers.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace spindle_twin::fem_offline

#pragma once

#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "firmware/watch/clock.hpp"

/// What makes poll() of a server return without anything to look at.
namespace spindle_twin::firmware {

/// Signals that end nothing but the wait that a thread is in.
class Interruption {
 public:
  Interruption() {
    struct sigaction quiet {};
    quiet.sa_handler = [](int) {};
    ::sigaction(SIGUSR1, &quiet, &before_);
  }
  ~Interruption() { ::sigaction(SIGUSR1, &before_, nullptr); }
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;
  static void of(std::thread& waiting) { ::pthread_kill(waiting.native_handle(), SIGUSR1); }

 private:
  struct sigaction before_ {};
};

/// While it lives, poll() refuses: more descriptors than this process may have. Those that are there stay usable.
class NoPoll {
 public:
  NoPoll() {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit none{2, before_.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &none);
  }
  ~NoPoll() { ::setrlimit(RLIMIT_NOFILE, &before_); }
  NoPoll(const NoPoll&) = delete;
  NoPoll& operator=(const NoPoll&) = delete;

 private:
  rlimit before_{};
};

/// Stands, and remembers for how long somebody wanted to sleep first; a sleep lasts until it is `awake`.
class RestingClock final : public Clock {
 public:
  std::int64_t now_ns() const override { return now_; }
  void sleep_until_ns(std::int64_t time_ns) override {
    if (rest_ns == 0) rest_ns = time_ns - now_;
    awake.wait(false);
  }
  /// For five seconds at most.
  void wait_until_it_rests() const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (rest_ns == 0 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  }
  void wake() {
    awake = true;
    awake.notify_all();
  }

  std::atomic<std::int64_t> rest_ns{0};
  std::atomic<bool> awake{false};

 private:
  std::atomic<std::int64_t> now_{1000 * ns_per_s};
};

}  // namespace spindle_twin::firmware

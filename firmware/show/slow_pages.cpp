#include "firmware/show/slow_pages.hpp"

#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <exception>
#include <new>
#include <utility>

#include "firmware/show/shown_spindle.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/keep_running.hpp"

namespace spindle_twin::firmware {

SlowPages::SlowPages() : ready_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (ready_.get() < 0) throw std::bad_alloc();
  thread_ = std::thread([this] { keep_running("slow pages", stop_, [this] { run(); }); });
}

SlowPages::~SlowPages() {
  stop();
  thread_.join();
}

void SlowPages::stop() {
  {
    const std::lock_guard lock(guard_);
    stop_.store(true, std::memory_order_release);
  }
  comes_.notify_all();
}

std::optional<std::uint64_t> SlowPages::ask(SlowWork work) {
  {
    const std::lock_guard lock(guard_);
    // Work that was forgotten while it is done takes its place too.
    const std::size_t taken = asked_.size() + made_.size() + (is_busy_ ? 1 : 0);
    if (stop_.load(std::memory_order_relaxed) || taken >= most_at_once) return std::nullopt;
    asked_.push_back({++last_, std::move(work)});
    wanted_.insert(last_);
  }
  comes_.notify_all();
  return last_;
}

void SlowPages::forget(std::uint64_t number) {
  const std::lock_guard lock(guard_);
  wanted_.erase(number);
  std::erase_if(asked_, [number](const Asked& each) { return each.number == number; });
  std::erase_if(made_, [number](const Made& each) { return each.number == number; });
}

std::vector<SlowPages::Made> SlowPages::take() {
  std::uint64_t count = 0;
  [[maybe_unused]] const ssize_t got = ::read(ready_.get(), &count, sizeof count);
  const std::lock_guard lock(guard_);
  for (const Made& each : made_) wanted_.erase(each.number);
  return std::exchange(made_, {});
}

/// Waits for work; nothing when it is time to stop.
std::optional<SlowPages::Asked> SlowPages::next() {
  std::unique_lock lock(guard_);
  is_busy_ = false;  // also where the work before ended in an error that nobody foresaw
  comes_.wait(lock, [this] { return stop_.load(std::memory_order_relaxed) || !asked_.empty(); });
  if (stop_.load(std::memory_order_relaxed)) return std::nullopt;
  Asked asked = std::move(asked_.front());
  asked_.pop_front();
  is_busy_ = true;
  return asked;
}

Page SlowPages::make(const SlowWork& work) {
  try {
    return work(stop_);
  } catch (const std::exception& error) {
    const auto before = complaints_.pass(MonotonicClock().now_ns());
    if (before) spdlog::error("http: {}{}", error.what(), LogLimit::also(*before));
    return {500, "application/json", error_json(error.what())};
  }
}

void SlowPages::hand_over(Made made) {
  {
    const std::lock_guard lock(guard_);
    is_busy_ = false;
    if (!wanted_.contains(made.number)) return;
    made_.push_back(std::move(made));
  }
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(ready_.get(), &one, sizeof one);
}

void SlowPages::run() {
  while (const std::optional<Asked> asked = next()) hand_over({asked->number, make(asked->work)});
}

}  // namespace spindle_twin::firmware

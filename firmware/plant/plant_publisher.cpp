#include "firmware/plant/plant_publisher.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "firmware/serve/fill_image.hpp"
#include "firmware/watch/deadline.hpp"

namespace spindle_twin::firmware {
namespace {

/// The device of a daemon whose only spindle has no name.
const char* const only_device = "spindle";

std::vector<PlantDevice> devices(const std::vector<SpindleToPublish>& spindles,
                                 const std::vector<std::string>& registers) {
  std::vector<PlantDevice> all;
  all.reserve(spindles.size());
  for (const SpindleToPublish& spindle : spindles) {
    all.push_back(
        {spindle.name.empty() ? only_device : spindle.name, std::make_unique<PlantMetrics>(spindle.names, registers)});
  }
  return all;
}

}  // namespace

PlantPublisher::PlantPublisher(const PlantPlan& plan, const std::vector<SpindleToPublish>& spindles, Clock& clock)
    : plan_(plan),
      clock_(clock),
      node_(plan.group, plan.node, devices(spindles, plan.registers), static_cast<std::size_t>(plan.queue)),
      link_(plan_, node_, counts_),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (wake_.get() < 0) throw std::bad_alloc();
  for (const SpindleToPublish& spindle : spindles) {
    spindles_.push_back(std::make_unique<Spindle>());
    spindles_.back()->stale_after_s = spindle.stale_after_s;
  }
}

PlantTime PlantPublisher::now() const {
  constexpr double ms_per_s = 1000.0;
  return {clock_.now_ns(), static_cast<std::uint64_t>(ms_per_s * unix_now_s())};
}

void PlantPublisher::sample(const PlantTime& now) {
  for (std::size_t s = 0; s < spindles_.size(); ++s) {
    Spindle& spindle = *spindles_[s];
    spindle.tap.read(spindle.snapshot);
    const Snapshot& snapshot = spindle.snapshot;
    if (snapshot.sequence == 0) continue;
    const std::int64_t age_ns = std::max<std::int64_t>(0, now.ns - snapshot.time_ns);
    if (1e-9 * static_cast<double>(age_ns) > spindle.stale_after_s) {
      node_.stop(s);
      continue;
    }
    if (snapshot.sequence == std::exchange(spindle.published, snapshot.sequence)) continue;
    RegisterImage image{};
    fill_image(snapshot, now.ns, image);
    constexpr std::int64_t ns_per_ms = 1'000'000;
    node_.add(s, now.ms - static_cast<std::uint64_t>(age_ns / ns_per_ms), node_.metrics(s).values(image));
  }
}

void PlantPublisher::wait(std::int64_t until_ns) {
  std::array<pollfd, 2> polled{{{wake_.get(), POLLIN, 0}, link_.waits_for()}};
  constexpr std::int64_t ns_per_ms = 1'000'000, longest_ms = 1000;
  const std::int64_t ms = std::clamp<std::int64_t>((until_ns - clock_.now_ns()) / ns_per_ms + 1, 0, longest_ms);
  poll(polled.data(), polled.size(), static_cast<int>(ms));
}

void PlantPublisher::run() {
  Deadline deadline(clock_.now_ns(), static_cast<std::int64_t>(1e9 * plan_.period_s));
  while (!stop_.load()) {
    const PlantTime moment = now();
    if (moment.ns >= deadline.due_ns()) {
      sample(moment);
      deadline.take(moment.ns);
    }
    link_.step(moment);
    wait(std::min(deadline.due_ns(), link_.due_ns()));
  }
  link_.leave();
}

void PlantPublisher::stop() {
  stop_.store(true);
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_.get(), &one, sizeof one);
}

}  // namespace spindle_twin::firmware

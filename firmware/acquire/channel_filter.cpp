#include "firmware/acquire/channel_filter.hpp"

#include <cmath>

namespace spindle_twin::firmware {

std::optional<Reading> ChannelFilter::take(const Reading& sample) {
  switch (plan_.kind) {
    case FilterPlan::Kind::mean:
      return take_mean(sample);
    case FilterPlan::Kind::low_pass:
      return take_low_pass(sample);
    default:
      return sample;
  }
}

std::optional<Reading> ChannelFilter::take_mean(const Reading& sample) {
  std::optional<Reading> made;
  if (samples_ > 0 && static_cast<double>(sample.time_ns - start_ns_) >= 1e9 * plan_.time_s) {
    const double middle_ns = after_start_ns_ / static_cast<double>(samples_);
    const double mean = numbers_ > 0 ? sum_ / static_cast<double>(numbers_) : not_a_value;
    made = Reading{mean, start_ns_ + static_cast<std::int64_t>(middle_ns)};
    clear();
  }
  if (samples_ == 0) {
    start_ns_ = sample.time_ns;
    sum_ = after_start_ns_ = 0.0;
  }
  ++samples_;
  after_start_ns_ += static_cast<double>(sample.time_ns - start_ns_);
  if (std::isfinite(sample.value)) {
    ++numbers_;
    sum_ += sample.value;
  }
  return made;
}

Reading ChannelFilter::take_low_pass(const Reading& sample) {
  if (!std::isfinite(sample.value)) {
    clear();
    return sample;
  }
  if (samples_ == 0) {
    sum_ = sample.value;
  } else {
    const double passed_s = 1e-9 * static_cast<double>(sample.time_ns - start_ns_);
    sum_ -= std::expm1(-passed_s / plan_.time_s) * (sample.value - sum_);
  }
  samples_ = 1;
  start_ns_ = sample.time_ns;
  return {sum_, sample.time_ns - static_cast<std::int64_t>(1e9 * plan_.time_s)};
}

}  // namespace spindle_twin::firmware

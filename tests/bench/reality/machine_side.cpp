#include "tests/bench/reality/machine_side.hpp"

#include <algorithm>
#include <cmath>

#include "tests/bench/reality/default_plan.hpp"

namespace spindle_twin::bench {
namespace {

constexpr double noise_K = 0.03;
constexpr double resolution_K = 0.01;
constexpr double drift_from_s = 900.0;
constexpr double touched_every_s = 1800.0;
constexpr double touch_off_deviation_m = 1e-6;
constexpr double gaps_from_s = 1200.0;
constexpr double gap_room_s = 1800.0;  // for each gap
constexpr std::uint32_t sensors_purpose = 21, gaps_purpose = 22, places_purpose = 23, pair_purpose = 24;

}  // namespace

MachineSide::MachineSide(const RealityTruth& truth, const Family& family, const Unplugging& unplugging)
    : truth_(truth), family_(family), unplugging_(unplugging), random_(random_of(truth.seed, sensors_purpose)) {
  for (double& offset_K : offset_K_) offset_K = family.offset_K * normal_(random_);
  drift_sign_ = normal_(random_) < 0.0 ? -1.0 : 1.0;
  std::mt19937_64 places = random_of(truth.seed, places_purpose);
  for (std::size_t s = 0; s < sensor_count; ++s) {
    place_[s] = family.displaced ? sensor_count + 2 * s + places() % 2 : s;
  }
  if (family.gaps != Gaps::none) draw_gaps();
  std::mt19937_64 pairs = random_of(truth.seed, pair_purpose);
  pair_[0] = pairs() % sensor_count;
  pair_[1] = (pair_[0] + 1 + pairs() % (sensor_count - 1)) % sensor_count;
}

bool MachineSide::is_faulty(std::size_t sensor) const {
  return family_.is_faulty(sensor) || (is_of_pair(sensor) && is_pair_exchanged(read_s_));
}

bool MachineSide::is_pair_exchanged(double time_s) const {
  return unplugging_.for_s > 0.0 && unplugging_.exchanged && time_s >= Unplugging::back_s;
}

bool MachineSide::is_silent(std::size_t sensor, double time_s) const {
  const bool unplugged = time_s >= Unplugging::back_s - unplugging_.for_s && time_s < Unplugging::back_s;
  return in_gap(time_s) || (unplugged && is_of_pair(sensor));
}

void MachineSide::draw_gaps() {
  std::mt19937_64 random = random_of(truth_.seed, gaps_purpose);
  std::array lengths_s{60.0, 300.0, 600.0};
  std::shuffle(lengths_s.begin(), lengths_s.end(), random);
  double room_from_s = gaps_from_s;
  for (const double length_s : lengths_s) {
    const double slack_s = gap_room_s - length_s - 300.0;
    const double from_s = room_from_s + slack_s * std::uniform_real_distribution<double>(0.0, 1.0)(random);
    gaps_.push_back({from_s, from_s + length_s});
    room_from_s += gap_room_s;
  }
}

bool MachineSide::in_gap(double time_s) const {
  return std::any_of(gaps_.begin(), gaps_.end(),
                     [&](const Gap& gap) { return time_s >= gap.from_s && time_s < gap.until_s; });
}

void MachineSide::tell(double time_s) {
  const bool gap = in_gap(time_s);
  read_sensors(time_s);
  frame_.connected = !gap;
  if (!gap || family_.gaps == Gaps::signals_known) read_signals(time_s);
  if (family_.touch_offs) touch_off(time_s);
}

void MachineSide::read_sensors(double time_s) {
  std::array<double, sensor_count> reading_K{};
  for (std::size_t s = 0; s < sensor_count; ++s) {
    const double now_K = truth_.place_K(place_[s], time_s);
    if (read_s_ < 0.0 || family_.lag_s <= 0.0) {
      lagged_K_[s] = now_K;
    } else {
      // Response of lag_s y' = u - y to a straight line between the two instants.
      const double step_s = time_s - read_s_;
      const double before_K = truth_.place_K(place_[s], read_s_);
      const double keep = std::exp(-step_s / family_.lag_s);
      const double slope_K = now_K - before_K;
      lagged_K_[s] =
          keep * lagged_K_[s] + (1.0 - keep) * before_K + slope_K * (1.0 - (1.0 - keep) * family_.lag_s / step_s);
    }
    reading_K[s] = lagged_K_[s] + offset_K_[s] + noise_K * normal_(random_);
  }
  read_s_ = time_s;
  reading_K[winding] += drift_sign_ * family_.winding_drift_K_per_h * std::max(0.0, time_s - drift_from_s) / 3600.0;
  if (family_.exchanged) std::swap(reading_K[front_seat], reading_K[jacket]);
  if (is_pair_exchanged(time_s)) std::swap(reading_K[pair_[0]], reading_K[pair_[1]]);
  for (std::size_t s = 0; s < sensor_count; ++s) {
    if (is_silent(s, time_s)) continue;
    frame_.sensors[s] = {resolution_K * std::round(reading_K[s] / resolution_K), clock_ns(time_s)};
  }
}

void MachineSide::read_signals(double time_s) {
  const TruthSample& now = truth_.held(time_s);
  const bool untold = family_.inlet_untold && truth_.event_s >= 0.0 && time_s >= truth_.event_s;
  const auto tell = [&](firmware::Signal signal, double value) {
    command_.signals[static_cast<std::size_t>(signal)] = {value, clock_ns(time_s)};
  };
  tell(firmware::Signal::speed, family_.speed_scale * now.speed_rpm);
  tell(firmware::Signal::load, now.load);
  tell(firmware::Signal::coolant, now.coolant_K + now.coolant_error_K - (untold ? truth_.inlet_step_K : 0.0));
  tell(firmware::Signal::ambient, now.ambient_K + now.ambient_error_K);
}

void MachineSide::touch_off(double time_s) {
  if (time_s < touched_s_ + touched_every_s) return;
  touched_s_ += touched_every_s;
  command_.displacement = {0, truth_.nose_m(time_s) + touch_off_deviation_m * normal_(random_), touch_off_deviation_m};
  ++command_.displacements;
}

}  // namespace spindle_twin::bench

#include <algorithm>
#include <cmath>

#include "firmware/cycle/cycle.hpp"

// What a cycle takes from another one that runs another network of the same spindle.
namespace spindle_twin::firmware {

void Cycle::identify(const std::string& network_sha256) {
  network_sha256_ = network_sha256;
  constexpr int hexadecimal = 16;
  constexpr std::size_t digits_of_32_bits = 8;
  snapshot_.network_id =
      static_cast<std::uint32_t>(std::stoul(network_sha256.substr(0, digits_of_32_bits), nullptr, hexadecimal));
}

void Cycle::begin_beside(const Cycle& running) {
  first_ns_ = running.first_ns_;
  has_stepped_ = running.has_stepped_;
  snapshot_.model_time_s = running.snapshot_.model_time_s;
  snapshot_.sequence = running.snapshot_.sequence;
  snapshot_.tare_m = running.snapshot_.tare_m;
  take_counts(running);
  judgement_.signals = running.judgement_.signals;
  judgement_.believed_ns = running.judgement_.believed_ns;
  watch_.tare = running.watch_.tare;  // the estimator has no offsets yet
  watch_.orders = running.watch_.orders;
  compensation_ = running.compensation_;
}

/// Orders that were obeyed, and what was counted since the start.
void Cycle::take_counts(const Cycle& running) {
  tare_orders_ = running.tare_orders_;
  displacements_ = running.displacements_;
  acknowledgements_ = running.acknowledgements_;
  acknowledgements_kept_ = running.acknowledgements_kept_;
  correction_order_ = running.correction_order_;
  snapshot_.tare_count = running.snapshot_.tare_count;
  snapshot_.overruns = running.snapshot_.overruns;
  snapshot_.sensor_orders = running.snapshot_.sensor_orders;
  snapshot_.sensor_order = running.snapshot_.sensor_order;
  snapshot_.displacement_orders = running.snapshot_.displacement_orders;
  snapshot_.displacement = running.snapshot_.displacement;
  constexpr auto of_orders = bits(Fault::orders_lost);
  snapshot_.fault = static_cast<std::uint16_t>((snapshot_.fault & ~of_orders) | (running.snapshot_.fault & of_orders));
}

void Cycle::take_over(const Cycle& shown, TareOf tare_of) {
  const double own_tare_m = snapshot_.tare_m + tare_to_come_m_;
  const double shown_tare_m = shown.snapshot_.tare_m;
  const bool tared = shown_tare_m != 0.0 || shown.tare_to_come_m_ != 0.0;
  double wanted_tare_m = own_tare_m;
  if (tare_of == TareOf::other && tared && snapshot_.deformations > 0) {
    const double apart_m = snapshot_.deformation_raw_m[0] - shown.snapshot_.deformation_raw_m[0];
    wanted_tare_m = shown_tare_m + shown.tare_to_come_m_ + apart_m;
  }
  snapshot_.sequence = shown.snapshot_.sequence;
  snapshot_.deformation_m = shown.snapshot_.deformation_m;
  snapshot_.tare_m = shown_tare_m;
  tare_to_come_m_ = tared || own_tare_m != 0.0 ? wanted_tare_m - shown_tare_m : 0.0;
  take_counts(shown);
  compensation_ = shown.compensation_;
}

void Cycle::move_tare(double most_m, double nose_moved_m) {
  if (tare_to_come_m_ == 0.0) return;
  // So that nose minus tare moves by no more than most_m either.
  const double least = std::max(-most_m, nose_moved_m - most_m);
  const double most = std::min(most_m, nose_moved_m + most_m);
  if (!(least <= most)) return;
  const double moved_m = std::clamp(tare_to_come_m_, least, most);
  snapshot_.tare_m += moved_m;
  tare_to_come_m_ -= moved_m;
  constexpr double nothing_m = 1e-15;
  if (std::abs(tare_to_come_m_) < nothing_m) tare_to_come_m_ = 0.0;
}

}  // namespace spindle_twin::firmware

#include "firmware/keep/order_keeper.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "firmware/keep/state_files.hpp"
#include "firmware/watch/clock.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {
namespace {

bool has_tares(const StandingOrders& orders) {
  const auto& tare_K = orders.sensor_tare_K;
  return orders.tare_m != 0.0 || std::any_of(tare_K.begin(), tare_K.end(), [](double each) { return each != 0.0; });
}

/// What a checkpoint says of tares; of another network nothing.
StandingOrders from_checkpoint(const std::optional<Checkpoint>& checkpoint, const std::string& network_sha256) {
  StandingOrders orders;
  if (!checkpoint || checkpoint->network_sha256 != network_sha256) return orders;
  const Remembered& remembered = checkpoint->remembered;
  orders.tare_m = remembered.tare_m;
  orders.sensor_tares = remembered.sensor_tare.count;
  const std::size_t count = std::min(slots::key_points, remembered.sensor_tare.offset_K.size());
  if (remembered.sensor_tare.deviation_K.size() < count) return orders;
  std::copy_n(remembered.sensor_tare.offset_K.begin(), count, orders.sensor_tare_K.begin());
  std::copy_n(remembered.sensor_tare.deviation_K.begin(), count, orders.sensor_tare_deviation_K.begin());
  return orders;
}

const char* name_of(SwitchOrder order) {
  if (order == SwitchOrder::as_configured) return "as configured";
  return order == SwitchOrder::on ? "on" : "off";
}

std::string told(const StandingOrders& orders) {
  return fmt::format("tare {:.2f} um, {} tares of the sensors, correction {}, compensation {}", 1e6 * orders.tare_m,
                     orders.sensor_tares, name_of(orders.correction), name_of(orders.compensation));
}

}  // namespace

StandingOrders recall_orders(const std::string& path, const std::string& network_sha256,
                             const std::optional<Checkpoint>& checkpoint, const std::string& sha256_before) {
  if (path.empty()) return {};
  StandingOrders orders = from_checkpoint(checkpoint, network_sha256);
  const std::uint32_t known = checkpoint ? checkpoint->order_revision : 0;
  std::string lost;
  bool aside = false;
  try {
    const std::optional<KeptOrders> kept = read_orders(path);
    if (kept) {
      const bool before = !sha256_before.empty() && kept->network_sha256 == sha256_before;
      const bool same = kept->network_sha256 == network_sha256 || before;
      if (before) spdlog::warn("orders {}: of the network before the exchange; tare again when convenient", path);
      const StandingOrders other = kept->orders;
      const StandingOrders stood_in = std::exchange(orders, other);
      if (!same) {
        orders.tare_m = 0.0;
        orders.sensor_tares = 0;
        orders.sensor_tare_K.fill(0.0);
        orders.sensor_tare_deviation_K.fill(0.0);
        aside = has_tares(other);
        if (aside) lost = "its tares are of another network";
      } else if (known > other.revision) {
        lost = "it is older than the checkpoint";
        orders = stood_in;
        orders.correction = other.correction;
        orders.compensation = other.compensation;
      }
      orders.lost = other.lost;
    } else if (known > 0) {
      lost = "it is missing";
    }
  } catch (const rom::InputError& error) {
    lost = error.what();
    aside = true;
  }
  if (aside) lost += put_state_aside(path);
  if (!lost.empty()) {
    orders.lost = true;
    spdlog::error("orders {}: lost, {}; in use: {}. Tare again, then acknowledge", path, lost, told(orders));
  } else if (orders.lost) {
    spdlog::warn("orders {}: some were lost before, nobody has acknowledged that; in use: {}", path, told(orders));
  } else {
    spdlog::info("orders {}: {}", path, told(orders));
  }
  orders.revision = std::max(orders.revision, known);
  return orders;
}

OrderKeeper::OrderKeeper(std::string path, std::string network_sha256, OrderDesk& desk, Troubles& troubles)
    : path_(std::move(path)), desk_(desk), troubles_(troubles) {
  kept_.network_sha256 = std::move(network_sha256);
}

void OrderKeeper::begin_with(const StandingOrders& recalled) {
  kept_.orders = recalled;
  desk_.begin_with(recalled);
  // Nothing was ordered yet: no file. Otherwise one that says what holds now, a loss too.
  if (recalled.lost || recalled.revision > 0 || has_tares(recalled)) keep();
}

bool OrderKeeper::keep() {
  const std::uint32_t revision = kept_.orders.revision;
  const auto now_ns = [] { return MonotonicClock().now_ns(); };
  try {
    kept_.saved_unix_s = unix_now_s();
    if (!path_.empty()) write_orders(kept_, path_);
  } catch (const rom::InputError& error) {
    desk_.note_not_kept(revision);
    troubles_.set(Fault::orders_not_kept, true);
    const auto before = complaints_.pass(now_ns());
    if (before) spdlog::error("orders: {}; a restart would forget them{}", error.what(), LogLimit::also(*before));
    return false;
  }
  desk_.note_kept(revision);
  revision_.store(revision, std::memory_order_release);
  troubles_.set(Fault::orders_not_kept, false);
  return true;
}

void OrderKeeper::run(const std::atomic<bool>& stop) {
  constexpr std::chrono::milliseconds slice(5);
  constexpr std::chrono::seconds patience(1);
  auto due = std::chrono::steady_clock::now();
  bool pending = (troubles_.faults() & bits(Fault::orders_not_kept)) != 0;
  while (true) {
    const bool last = stop.load(std::memory_order_acquire);
    const bool fresh = desk_.standing().read(kept_.orders);
    const auto& network = kept_.orders.network_sha256;
    if (fresh && network[0] != '\0') kept_.network_sha256.assign(network.begin(), network.end());
    if (fresh || (pending && (last || std::chrono::steady_clock::now() >= due))) {
      pending = !keep();
      due = std::chrono::steady_clock::now() + patience;
    }
    if (last) return;
    std::this_thread::sleep_for(slice);
  }
}

}  // namespace spindle_twin::firmware

#include "firmware/keep/orders_file.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "firmware/keep/orders.pb.h"
#include "firmware/keep/state_files.hpp"
#include "rom/file/packed_message.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {
namespace {

using rom::attach;
using rom::Way;

using OrdersMessage = spindle_twin_firmware_Orders;

constexpr const char* orders_format = "orders 1";
constexpr std::uint64_t largest_bytes = 1 << 16;

/// The fields that nanopb hands over by callback.
struct Lists {
  std::string network_sha256;
  std::vector<double> tare_K;
  std::vector<double> deviation_K;
};

template <Way way>
OrdersMessage message_of(const Lists& lists) {
  OrdersMessage message = spindle_twin_firmware_Orders_init_zero;
  message.network_sha256 = attach<way>(lists.network_sha256);
  message.sensor_tare_K = attach<way>(lists.tare_K);
  message.sensor_tare_deviation_K = attach<way>(lists.deviation_K);
  return message;
}

bool are_within(const std::vector<double>& numbers, double least, double most) {
  return numbers.size() == slots::key_points &&
         std::all_of(numbers.begin(), numbers.end(), [&](double each) { return each >= least && each <= most; });
}

}  // namespace

std::vector<std::uint8_t> encode_orders(const KeptOrders& kept) {
  const StandingOrders& orders = kept.orders;
  const Lists lists{kept.network_sha256,
                    {orders.sensor_tare_K.begin(), orders.sensor_tare_K.end()},
                    {orders.sensor_tare_deviation_K.begin(), orders.sensor_tare_deviation_K.end()}};
  OrdersMessage message = message_of<Way::encode>(lists);
  message.saved_unix_s = kept.saved_unix_s;
  message.revision = orders.revision;
  message.correction = static_cast<std::uint32_t>(orders.correction);
  message.compensation = static_cast<std::uint32_t>(orders.compensation);
  message.tare_m = orders.tare_m;
  message.sensor_tares = orders.sensor_tares;
  message.acknowledgements = orders.acknowledgements;
  message.lost = orders.lost;
  return rom::seal(orders_format, spindle_twin_firmware_Orders_fields, &message);
}

KeptOrders decode_orders(const std::vector<std::uint8_t>& bytes, const std::string& file) {
  const std::span<const std::uint8_t> payload = rom::unseal(orders_format, bytes, file);
  Lists lists;
  OrdersMessage message = message_of<Way::decode>(lists);
  pb_istream_t stream = pb_istream_from_buffer(payload.data(), payload.size());
  const bool read = pb_decode(&stream, spindle_twin_firmware_Orders_fields, &message);
  const bool plausible = read && std::abs(message.tare_m) <= most_tare_m && message.correction <= 2 &&
                         message.compensation <= 2 &&
                         are_within(lists.tare_K, -most_sensor_tare_K, most_sensor_tare_K) &&
                         are_within(lists.deviation_K, 0.0, most_sensor_tare_K);
  if (!plausible) throw rom::InputError({file, 0}, "", "malformed");
  KeptOrders kept;
  kept.network_sha256 = lists.network_sha256;
  kept.saved_unix_s = message.saved_unix_s;
  StandingOrders& orders = kept.orders;
  orders.revision = message.revision;
  orders.correction = static_cast<SwitchOrder>(message.correction);
  orders.compensation = static_cast<SwitchOrder>(message.compensation);
  orders.tare_m = message.tare_m;
  orders.sensor_tares = message.sensor_tares;
  std::copy(lists.tare_K.begin(), lists.tare_K.end(), orders.sensor_tare_K.begin());
  std::copy(lists.deviation_K.begin(), lists.deviation_K.end(), orders.sensor_tare_deviation_K.begin());
  orders.acknowledgements = message.acknowledgements;
  orders.lost = message.lost;
  return kept;
}

void write_orders(const KeptOrders& kept, const std::string& path) { rom::write_whole_file(path, encode_orders(kept)); }

std::optional<KeptOrders> read_orders(const std::string& path) {
  if (!exists_as_file(path)) return std::nullopt;
  return decode_orders(rom::read_whole_file(path, largest_bytes), path);
}

}  // namespace spindle_twin::firmware

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/cycle/order_desk.hpp"

namespace spindle_twin::firmware {

/// Standing orders and the network whose nose and key points they are of.
struct KeptOrders {
  std::string network_sha256;
  double saved_unix_s = 0.0;
  StandingOrders orders;
};

/// A line that names the format and the SHA-256 of what follows, then the payload of keep/orders.proto (nanopb).
std::vector<std::uint8_t> encode_orders(const KeptOrders& kept);

/// Throws rom::InputError naming `file` for anything that encode_orders did not write, and for numbers that no order
/// can have set.
KeptOrders decode_orders(const std::vector<std::uint8_t>& bytes, const std::string& file);

/// On the disk when it returns, whole or not at all. Throws rom::InputError with the system's reason.
void write_orders(const KeptOrders& kept, const std::string& path);

/// Empty where there is no file. Throws rom::InputError for one that cannot be used.
std::optional<KeptOrders> read_orders(const std::string& path);

}  // namespace spindle_twin::firmware

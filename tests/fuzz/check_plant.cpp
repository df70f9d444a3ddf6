#include "tests/fuzz/check_plant.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/plant/edge_node.hpp"
#include "tests/fuzz/require.hpp"

namespace spindle_twin::firmware {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// One field as it stands on the wire.
struct Field {
  std::uint64_t number = 0;
  unsigned wire_type = 0;
  std::uint64_t value = 0;  ///< of wire type 0
  Bytes content = {};       ///< of wire type 2
};

/// Of one with more than 64 bits the first of them: nanopb skips such a one in a field that it does not know.
std::optional<std::uint64_t> take_varint(Bytes& bytes) {
  std::uint64_t value = 0;
  for (unsigned place = 0; !bytes.empty(); place += 7) {
    const std::uint8_t byte = bytes.front();
    bytes = bytes.subspan(1);
    if (place < 64) value |= std::uint64_t{byte & 0x7FU} << place;
    if ((byte & 0x80U) == 0) return value;
  }
  return std::nullopt;
}

/// The next field of a message of Protocol Buffers; nothing where it is damaged or of a type that proto3 does not have.
std::optional<Field> take_field(Bytes& bytes) {
  const std::optional<std::uint64_t> tag = take_varint(bytes);
  if (!tag || *tag >> 3U == 0) return std::nullopt;
  Field field{*tag >> 3U, static_cast<unsigned>(*tag & 7U)};
  std::uint64_t length = 0;
  switch (field.wire_type) {
    case 0: {
      const std::optional<std::uint64_t> value = take_varint(bytes);
      field.value = value.value_or(0);
      return value ? std::optional(field) : std::nullopt;
    }
    case 1:
      length = 8;
      break;
    case 2: {
      const std::optional<std::uint64_t> said = take_varint(bytes);
      if (!said) return std::nullopt;
      length = *said;
      break;
    }
    case 5:
      length = 4;
      break;
    default:
      return std::nullopt;
  }
  if (length > bytes.size()) return std::nullopt;
  field.content = bytes.first(length);
  bytes = bytes.subspan(length);
  return field;
}

/// The message's fields, and whether all of it could be read.
std::pair<std::vector<Field>, bool> fields_of(Bytes bytes) {
  std::vector<Field> fields;
  while (!bytes.empty()) {
    const std::optional<Field> field = take_field(bytes);
    if (!field) return {fields, false};
    fields.push_back(*field);
  }
  return {fields, true};
}

constexpr std::string_view order_name = "Node Control/Rebirth";
constexpr std::uint64_t metrics_number = 2, name_number = 1, boolean_number = 14;

bool is_order(Bytes metric) {
  std::string_view name;
  bool value = false;
  for (const Field& field : fields_of(metric).first) {
    // The last one counts; of another wire type it has no content.
    if (field.number == name_number) {
      name = {reinterpret_cast<const char*>(field.content.data()), field.wire_type == 2 ? field.content.size() : 0};
    }
    if (field.number == boolean_number && field.wire_type == 0) value = field.value != 0;
  }
  return name == order_name && value;
}

std::vector<std::uint8_t> joined(Bytes first, Bytes second) {
  std::vector<std::uint8_t> both(first.begin(), first.end());
  both.insert(both.end(), second.begin(), second.end());
  return both;
}

}  // namespace

std::string checked_command(std::span<const std::uint8_t> payload) {
  static const EdgeNode node("group", "node", {}, 1);
  static const std::vector<std::uint8_t> order = [] {
    PayloadMessage message;
    message.metrics.push_back({.name = std::string(order_name), .type = DataType::boolean, .value = 1.0});
    return encode_payload(message);
  }();
  const auto [fields, is_read] = fields_of(payload);
  const bool holds_order = std::any_of(fields.begin(), fields.end(), [](const Field& field) {
    return field.number == metrics_number && field.wire_type == 2 && is_order(field.content);
  });
  const bool is_obeyed = node.asks_for_birth(payload);
  require(!is_obeyed || holds_order, "what is obeyed holds the order");
  require(!is_obeyed || is_read, "a damaged payload is not obeyed");
  // Messages of Protocol Buffers may stand behind each other. With an order beside it a payload that can be read is
  // obeyed.
  const bool is_taken = node.asks_for_birth(joined(order, payload));
  require(is_read || !is_taken, "a damaged payload spoils the order before it");
  // Behind a cut one the order would be taken for what was cut off.
  require(!is_read || is_taken == node.asks_for_birth(joined(payload, order)), "it does not matter which stands first");
  require(is_obeyed == (is_taken && holds_order), "a payload that can be read and holds the order is obeyed");
  if (!is_taken) return "damaged";
  return is_obeyed ? "" : "does not ask for births";
}

}  // namespace spindle_twin::firmware

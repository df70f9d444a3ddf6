#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/plant/plant_metrics.hpp"

namespace spindle_twin::firmware {

/// One metric of a message. What is empty is not in the message.
struct PayloadMetric {
  std::string name = {};
  std::optional<std::uint64_t> alias = std::nullopt;
  DataType type = DataType::float32;
  double value = 0.0;     ///< NaN: null, also of a text
  std::string text = {};  ///< of a metric that is a string
  bool is_historical = false;
  std::string unit = {};
  std::optional<MetricQuality> quality = std::nullopt;
};

/// One message, whose metrics are all of one moment.
struct PayloadMessage {
  std::uint64_t time_ms = 0;  ///< since 1970; of the message, and of the metrics where they have no time of their own
  std::optional<std::uint64_t> metrics_time_ms = std::nullopt;
  std::optional<std::uint8_t> seq = std::nullopt;
  std::vector<PayloadMetric> metrics = {};
};

/// The message in Sparkplug B's form (sparkplug_b.proto). Values go into the standard's field for their type; one that
/// does not fit is clipped. Throws std::logic_error for what cannot be encoded. Allocates; not for the cycle.
std::vector<std::uint8_t> encode_payload(const PayloadMessage& message);

/// Whether the payload, of whatever origin, sets the Boolean metric `name` to true. Damaged ones do not.
bool sets_true(std::span<const std::uint8_t> payload, const std::string& name);

}  // namespace spindle_twin::firmware

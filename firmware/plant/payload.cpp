#include "firmware/plant/payload.hpp"

#include <pb_decode.h>
#include <pb_encode.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "firmware/plant/sparkplug_b.pb.h"

namespace spindle_twin::firmware {
namespace {

/// nanopb calls this back with a std::string.
bool put_text(pb_ostream_t* stream, const pb_field_t* field, void* const* arg) {
  const auto& text = *static_cast<const std::string*>(*arg);
  return pb_encode_tag_for_field(stream, field) &&
         pb_encode_string(stream, reinterpret_cast<const pb_byte_t*>(text.data()), text.size());
}

pb_callback_t text_field(const std::string& text) {
  pb_callback_t callback{};
  callback.funcs.encode = put_text;
  callback.arg = const_cast<std::string*>(&text);
  return callback;
}

const std::string unit_key = "engUnit", quality_key = "Quality";

bool put_property_keys(pb_ostream_t* stream, const pb_field_t* field, void* const* arg) {
  const auto& metric = *static_cast<const PayloadMetric*>(*arg);
  const auto put = [&](const std::string& key) {
    void* const text = const_cast<std::string*>(&key);
    return put_text(stream, field, &text);
  };
  return (metric.unit.empty() || put(unit_key)) && (!metric.quality || put(quality_key));
}

bool put_property_values(pb_ostream_t* stream, const pb_field_t* field, void* const* arg) {
  const auto& metric = *static_cast<const PayloadMetric*>(*arg);
  const auto put = [&](const spindle_twin_plant_PropertyValue& value) {
    return pb_encode_tag_for_field(stream, field) &&
           pb_encode_submessage(stream, spindle_twin_plant_PropertyValue_fields, &value);
  };
  if (!metric.unit.empty()) {
    spindle_twin_plant_PropertyValue unit = spindle_twin_plant_PropertyValue_init_zero;
    unit.has_type = true;
    unit.type = static_cast<std::uint32_t>(DataType::string);
    unit.string_value = text_field(metric.unit);
    if (!put(unit)) return false;
  }
  if (!metric.quality) return true;
  spindle_twin_plant_PropertyValue quality = spindle_twin_plant_PropertyValue_init_zero;
  quality.has_type = quality.has_int_value = true;
  quality.type = static_cast<std::uint32_t>(DataType::int32);
  quality.int_value = static_cast<std::uint32_t>(*metric.quality);
  return put(quality);
}

template <class Integer>
Integer clipped(double value) {
  constexpr double least = std::numeric_limits<Integer>::min(), most = std::numeric_limits<Integer>::max();
  return static_cast<Integer>(std::clamp(std::round(value), least, most));
}

void set_value(const PayloadMetric& from, spindle_twin_plant_Metric& to) {
  if (std::isnan(from.value)) {
    to.has_is_null = to.is_null = true;
    return;
  }
  switch (from.type) {
    case DataType::int32:
      to.has_int_value = true;
      to.int_value = static_cast<std::uint32_t>(clipped<std::int32_t>(from.value));
      return;
    case DataType::uint16:
      to.has_int_value = true;
      to.int_value = clipped<std::uint16_t>(from.value);
      return;
    case DataType::int64:
      to.has_long_value = true;
      to.long_value = clipped<std::uint32_t>(from.value);  // no number here is larger, none less than 0
      return;
    case DataType::boolean:
      to.has_boolean_value = true;
      to.boolean_value = from.value != 0.0;
      return;
    case DataType::string:
      to.string_value = text_field(from.text);
      return;
    case DataType::float32:
      to.has_float_value = true;
      to.float_value = static_cast<float>(from.value);
      return;
  }
}

spindle_twin_plant_Metric metric_message(const PayloadMetric& from, std::uint64_t time_ms) {
  spindle_twin_plant_Metric to = spindle_twin_plant_Metric_init_zero;
  if (!from.name.empty()) to.name = text_field(from.name);
  to.has_alias = from.alias.has_value();
  to.alias = from.alias.value_or(0);
  to.has_timestamp = true;
  to.timestamp = time_ms;
  to.has_datatype = true;
  to.datatype = static_cast<std::uint32_t>(from.type);
  to.has_is_historical = to.is_historical = from.is_historical;
  set_value(from, to);
  if (from.unit.empty() && !from.quality) return to;
  to.has_properties = true;
  void* const metric = const_cast<PayloadMetric*>(&from);
  to.properties.keys.funcs.encode = put_property_keys;
  to.properties.values.funcs.encode = put_property_values;
  to.properties.keys.arg = to.properties.values.arg = metric;
  return to;
}

bool put_metrics(pb_ostream_t* stream, const pb_field_t* field, void* const* arg) {
  const auto& message = *static_cast<const PayloadMessage*>(*arg);
  const std::uint64_t time_ms = message.metrics_time_ms.value_or(message.time_ms);
  return std::all_of(message.metrics.begin(), message.metrics.end(), [&](const PayloadMetric& metric) {
    const spindle_twin_plant_Metric each = metric_message(metric, time_ms);
    return pb_encode_tag_for_field(stream, field) &&
           pb_encode_submessage(stream, spindle_twin_plant_Metric_fields, &each);
  });
}

/// The name that is looked for, and what became of the search.
struct Search {
  const std::string& name;
  bool found = false;
};

/// What the stream holds is bounded by the payload, which nanopb has checked.
bool take_text(pb_istream_t* stream, const pb_field_t*, void** arg) {
  auto& text = *static_cast<std::string*>(*arg);
  text.resize(stream->bytes_left);
  return pb_read(stream, reinterpret_cast<pb_byte_t*>(text.data()), text.size());
}

bool take_metric(pb_istream_t* stream, const pb_field_t*, void** arg) {
  auto& search = *static_cast<Search*>(*arg);
  spindle_twin_plant_Metric metric = spindle_twin_plant_Metric_init_zero;
  std::string name;
  metric.name.funcs.decode = take_text;
  metric.name.arg = &name;
  if (!pb_decode(stream, spindle_twin_plant_Metric_fields, &metric)) return false;
  if (name == search.name && metric.has_boolean_value && metric.boolean_value) search.found = true;
  return true;
}

}  // namespace

std::vector<std::uint8_t> encode_payload(const PayloadMessage& message) {
  spindle_twin_plant_Payload payload = spindle_twin_plant_Payload_init_zero;
  payload.has_timestamp = true;
  payload.timestamp = message.time_ms;
  payload.has_seq = message.seq.has_value();
  payload.seq = message.seq.value_or(0);
  payload.metrics.funcs.encode = put_metrics;
  payload.metrics.arg = const_cast<PayloadMessage*>(&message);
  std::size_t size = 0;
  if (!pb_get_encoded_size(&size, spindle_twin_plant_Payload_fields, &payload)) {
    throw std::logic_error("a message to the plant has no size");
  }
  std::vector<std::uint8_t> bytes(size);
  pb_ostream_t stream = pb_ostream_from_buffer(bytes.data(), bytes.size());
  if (!pb_encode(&stream, spindle_twin_plant_Payload_fields, &payload)) {
    throw std::logic_error("a message to the plant cannot be encoded");
  }
  return bytes;
}

bool sets_true(std::span<const std::uint8_t> payload, const std::string& name) {
  Search search{name};
  spindle_twin_plant_Payload message = spindle_twin_plant_Payload_init_zero;
  message.metrics.funcs.decode = take_metric;
  message.metrics.arg = &search;
  pb_istream_t stream = pb_istream_from_buffer(payload.data(), payload.size());
  return pb_decode(&stream, spindle_twin_plant_Payload_fields, &message) && search.found;
}

}  // namespace spindle_twin::firmware

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// Faults of a program that writes a protobuf message: each of its fields missing, repeated, or with another value, one
/// at a time. Knows the wire format only (protobuf.dev, encoding), not the schema.
namespace spindle_twin::tests {

using Bytes = std::vector<std::uint8_t>;

struct WireField {
  enum class Kind { whole, fixed, message, text, numbers };
  std::uint64_t number = 0;
  std::uint64_t wire_type = 0;
  Kind kind = Kind::whole;
  std::uint64_t value = 0;        ///< of a whole number
  Bytes bytes;                    ///< of a fixed one, a text, packed numbers
  std::vector<WireField> fields;  ///< of a message
};

inline std::optional<std::uint64_t> take_varint(std::span<const std::uint8_t>& from) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64 && !from.empty(); shift += 7) {
    const std::uint8_t byte = from.front();
    from = from.subspan(1);
    value |= static_cast<std::uint64_t>(byte & 0x7fU) << shift;
    if (byte < 0x80) return value;
  }
  return std::nullopt;
}

inline void put_varint(std::uint64_t value, Bytes& to) {
  for (; value >= 0x80; value >>= 7) to.push_back(static_cast<std::uint8_t>(value | 0x80));
  to.push_back(static_cast<std::uint8_t>(value));
}

inline std::optional<std::vector<WireField>> take_message(std::span<const std::uint8_t> from);

/// What a length-delimited field holds, as far as that can be seen without the schema.
inline void take_inside(std::span<const std::uint8_t> part, WireField& field) {
  field.bytes.assign(part.begin(), part.end());
  const bool is_text = std::all_of(part.begin(), part.end(), [](std::uint8_t c) { return c >= 0x20 && c < 0x7f; });
  auto fields = is_text ? std::nullopt : take_message(part);
  field.kind = is_text ? WireField::Kind::text : fields ? WireField::Kind::message : WireField::Kind::numbers;
  if (fields) field.fields = std::move(*fields);
}

inline std::optional<std::vector<WireField>> take_message(std::span<const std::uint8_t> from) {
  std::vector<WireField> fields;
  while (!from.empty()) {
    const auto tag = take_varint(from);
    if (!tag || *tag >> 3 == 0 || *tag >> 3 > 100) return std::nullopt;
    WireField field;
    field.number = *tag >> 3;
    field.wire_type = *tag & 7U;
    if (field.wire_type == 0) {
      const auto value = take_varint(from);
      if (!value) return std::nullopt;
      field.value = *value;
    } else if (field.wire_type == 1 || field.wire_type == 2) {
      const auto length = field.wire_type == 1 ? std::optional<std::uint64_t>{8} : take_varint(from);
      if (!length || *length > from.size()) return std::nullopt;
      if (field.wire_type == 1) {
        field.kind = WireField::Kind::fixed;
        field.bytes.assign(from.begin(), from.begin() + 8);
      } else {
        take_inside(from.first(*length), field);
      }
      from = from.subspan(*length);
    } else {
      return std::nullopt;
    }
    fields.push_back(std::move(field));
  }
  return fields;
}

inline Bytes written(const std::vector<WireField>& fields) {
  Bytes to;
  for (const WireField& field : fields) {
    put_varint(field.number << 3 | field.wire_type, to);
    if (field.wire_type == 0) {
      put_varint(field.value, to);
      continue;
    }
    const Bytes inside = field.kind == WireField::Kind::message ? written(field.fields) : field.bytes;
    if (field.wire_type == 2) put_varint(inside.size(), to);
    to.insert(to.end(), inside.begin(), inside.end());
  }
  return to;
}

inline Bytes bytes_of(double value) {
  Bytes bytes(sizeof value);
  std::memcpy(bytes.data(), &value, sizeof value);  // little endian, as the wire
  return bytes;
}

/// A sum to which every number of a message adds its logarithm and every text its letters.
inline double sum_of(const std::vector<WireField>& fields) {
  constexpr double smallest = 1e-12;
  double sum = 0.0, weight = 1.0;
  const auto add = [&](double number) {
    weight += 1e-3;
    if (std::isfinite(number))
      sum += weight * std::copysign(std::log1p(std::min(std::abs(number), 1e200) / smallest), number);
  };
  for (const WireField& field : fields) {
    add(static_cast<double>(field.number));
    if (field.kind == WireField::Kind::whole) {
      add(static_cast<double>(field.value));
    } else if (field.kind == WireField::Kind::message) {
      sum += weight * sum_of(field.fields);
    } else if (field.kind == WireField::Kind::text || field.bytes.size() % 8 != 0) {
      for (const std::uint8_t letter : field.bytes) add(letter);
    } else {
      for (std::size_t at = 0; at < field.bytes.size(); at += 8) {
        double number = 0.0;
        std::memcpy(&number, field.bytes.data() + at, sizeof number);
        add(number);
      }
    }
  }
  return sum;
}
inline double sum_of_message(std::span<const std::uint8_t> message) { return sum_of(take_message(message).value()); }

/// Tells `visit` of each fault: what it is ("4.2 no", "4.2 nan": fields by number from the outside in), and the message
/// with it. Of the fields at one place the first `of_each` are made faulty.
class WireFaults {
 public:
  using Visit = std::function<void(const std::string& what, const Bytes& message)>;

  WireFaults(std::span<const std::uint8_t> message, int of_each, Visit visit)
      : fields_(take_message(message).value()), of_each_(of_each), visit_(std::move(visit)) {
    walk(fields_, "");
  }

 private:
  void tell(const std::string& what) const { visit_(what, written(fields_)); }

  void walk(std::vector<WireField>& fields, const std::string& outside) {
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const std::string place = outside + std::to_string(fields[i].number);
      if (seen_[place]++ >= of_each_) continue;
      const WireField good = fields[i];
      fields.erase(fields.begin() + static_cast<std::ptrdiff_t>(i));
      tell(place + " no");
      fields.insert(fields.begin() + static_cast<std::ptrdiff_t>(i), 2, good);
      tell(place + " twice");
      fields.erase(fields.begin() + static_cast<std::ptrdiff_t>(i));
      change(fields[i], good, place);
      fields[i] = good;
      if (good.kind == WireField::Kind::message) walk(fields[i].fields, place + ".");
    }
  }

  void change(WireField& field, const WireField& good, const std::string& place) {
    const auto with = [&](const char* what, const Bytes& bytes) {
      field.bytes = bytes;
      tell(place + " " + what);
      field = good;
    };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    switch (good.kind) {
      case WireField::Kind::whole:
        for (const std::uint64_t value : {0U, 1U, 3U, 4'000'000'000U}) {
          field.value = value;
          tell(place + " " + std::to_string(value));
        }
        break;
      case WireField::Kind::fixed:
        with("nan", bytes_of(nan));
        with("-1", bytes_of(-1.0));
        with("0", bytes_of(0.0));
        with("0.37", bytes_of(0.37));
        with("1e300", bytes_of(1e300));
        break;
      case WireField::Kind::text:
        with("empty", {});
        with("x", {'x'});
        break;
      case WireField::Kind::message:
        field.fields.clear();
        tell(place + " empty");
        break;
      case WireField::Kind::numbers:
        change_numbers(field, good, place);
        break;
    }
  }

  /// Packed doubles, or packed whole numbers, whose first byte is then enough.
  void change_numbers(WireField& field, const WireField& good, const std::string& place) {
    const std::size_t width = good.bytes.size() % 8 == 0 ? 8 : 1;
    field.bytes.resize(good.bytes.size() - width);
    tell(place + " short");
    field.bytes = good.bytes;
    field.bytes.insert(field.bytes.end(), width, 0);
    tell(place + " long");
    if (width == 8) {
      for (const double value : {std::numeric_limits<double>::quiet_NaN(), -1.0, 1e300}) {
        const Bytes bytes = bytes_of(value);
        for (const bool last : {false, true}) {
          field.bytes = good.bytes;
          std::copy(bytes.begin(), bytes.end(), last ? field.bytes.end() - 8 : field.bytes.begin());
          char number[32];
          std::snprintf(number, sizeof number, "%g", value);
          tell(place + (last ? " last " : " first ") + number);
        }
      }
    } else {
      field.bytes = good.bytes;
      field.bytes.front() = 0x7f;
      tell(place + " first 127");
    }
  }

  std::vector<WireField> fields_;
  int of_each_;
  Visit visit_;
  std::map<std::string, int> seen_;
};

}  // namespace spindle_twin::tests

#pragma once

#include <pb_decode.h>
#include <pb_encode.h>

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace spindle_twin::rom {

enum class Way { encode, decode };

// nanopb calls these back with the `arg` that attach() gives them.
bool pack_text(pb_ostream_t* stream, const pb_field_t* field, void* const* arg);
bool pack_numbers(pb_ostream_t* stream, const pb_field_t* field, void* const* arg);
bool unpack_text(pb_istream_t* stream, const pb_field_t* field, void** arg);
bool unpack_numbers(pb_istream_t* stream, const pb_field_t* field, void** arg);

/// A field of a message that is `item`, a std::string or a std::vector<double>, which must outlive the message. nanopb
/// has one pointer type for both directions.
template <Way way, class Item>
pb_callback_t attach(const Item& item) {
  pb_callback_t callback{};
  constexpr bool is_text = std::is_same_v<Item, std::string>;
  static_assert(is_text || std::is_same_v<Item, std::vector<double>>);
  if constexpr (way == Way::encode) {
    callback.funcs.encode = is_text ? pack_text : pack_numbers;
  } else {
    callback.funcs.decode = is_text ? unpack_text : unpack_numbers;
  }
  callback.arg = const_cast<Item*>(&item);
  return callback;
}

/// A line that names the format and the SHA-256 of what follows, then the encoded message. Throws std::logic_error for
/// a message that cannot be encoded.
std::vector<std::uint8_t> seal(const std::string& format, const pb_msgdesc_t* fields, const void* message);

/// The payload of what seal() made with the same format. Throws rom::InputError naming `file` for anything else:
/// another format, damaged by a single bit, cut.
std::span<const std::uint8_t> unseal(const std::string& format, std::span<const std::uint8_t> bytes,
                                     const std::string& file);

}  // namespace spindle_twin::rom

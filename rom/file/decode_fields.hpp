#pragma once

#include <pb_decode.h>

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "rom/file/payload.hpp"

/// How nanopb fills strings, vectors, matrices and lists; used by decode_*.cpp only.
namespace spindle_twin::rom {

using Field = const pb_field_t*;

// nanopb calls these back with the `arg` that the functions below attach. What they allocate is bounded by the bytes
// that are left in the (sub)message, which nanopb has checked against the buffer.

inline bool decode_text(pb_istream_t* stream, Field, void** arg) {
  auto& text = *static_cast<std::string*>(*arg);
  text.resize(stream->bytes_left);
  return pb_read(stream, reinterpret_cast<pb_byte_t*>(text.data()), text.size());
}

template <class Item>
inline constexpr std::size_t most = most_items;
template <>
inline constexpr std::size_t most<Node> = most_nodes;

/// Packed doubles into a column; reshaped when the number of nodes is known.
template <class Matrix>
bool decode_numbers(pb_istream_t* stream, Field, void** arg) {
  auto& numbers = *static_cast<Matrix*>(*arg);
  numbers.resize(static_cast<Eigen::Index>(stream->bytes_left / sizeof(double)), 1);
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    if (!pb_decode_fixed64(stream, numbers.data() + i)) return false;
  }
  return true;
}

template <class Item, bool (*decode_item)(pb_istream_t*, Item&)>
bool decode_list(pb_istream_t* stream, Field, void** arg) {
  auto& list = *static_cast<std::vector<Item>*>(*arg);
  if (list.size() == most<Item>) PB_RETURN_ERROR(stream, "a list is too long");
  Item item;
  if (!decode_item(stream, item)) return false;
  list.push_back(std::move(item));
  return true;
}

inline pb_callback_t attach(void* target, bool (*decode)(pb_istream_t*, Field, void**)) {
  pb_callback_t callback{};
  callback.funcs.decode = decode;
  callback.arg = target;
  return callback;
}

inline pb_callback_t attach(std::string& text) { return attach(&text, decode_text); }
inline pb_callback_t attach(Eigen::VectorXd& numbers) { return attach(&numbers, decode_numbers<Eigen::VectorXd>); }
inline pb_callback_t attach(Eigen::MatrixXd& numbers) { return attach(&numbers, decode_numbers<Eigen::MatrixXd>); }

template <class Item, bool (*decode_item)(pb_istream_t*, Item&)>
pb_callback_t attach_list(std::vector<Item>& list) {
  return attach(&list, decode_list<Item, decode_item>);
}

}  // namespace spindle_twin::rom

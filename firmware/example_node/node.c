#include "firmware/example_node/node.h"

#include <pb_encode.h>

enum { header_bytes = 10, crc_bytes = 4 };

static void put_big_endian(uint32_t number, int bytes, uint8_t *to) {
  for (int i = 0; i < bytes; ++i) to[i] = (uint8_t)(number >> (8 * (bytes - 1 - i)));
}

/* Bit by bit: 2 kB take some 0.3 ms at 100 MHz; a table of 1 kB makes it eight times as fast. */
static uint32_t crc32_of(const uint8_t *bytes, size_t count) {
  uint32_t crc = 0xFFFFFFFFu;
  for (size_t i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

static void empty(struct node *node) {
  node->message.readings_count = 0;
  node->message.burst.values_count = 0;
  node->message.has_burst = false;
}

void node_start(struct node *node) {
  node->sequence = 0;
  empty(node);
}

bool node_add(struct node *node, uint32_t channel, float value, uint32_t age_ms) {
  spindle_twin_stream_Readings *message = &node->message;
  const size_t room = sizeof message->readings / sizeof message->readings[0];
  if (message->readings_count >= room) return false;
  spindle_twin_stream_Reading *reading = &message->readings[message->readings_count++];
  reading->channel = channel;
  reading->value = value;
  reading->age_ms = age_ms;
  return true;
}

bool node_add_fast(struct node *node, uint32_t channel, float value, uint32_t interval_us) {
  spindle_twin_stream_Burst *burst = &node->message.burst;
  const size_t room = sizeof burst->values / sizeof burst->values[0];
  if (burst->values_count >= room) return false;
  node->message.has_burst = true;
  burst->channel = channel;
  burst->age_ms = 0;
  burst->interval_us = interval_us;
  burst->values[burst->values_count++] = value;
  return true;
}

size_t node_frame(struct node *node, uint32_t time_ms, uint8_t frame[NODE_FRAME_ROOM]) {
  node->message.time_ms = time_ms;
  pb_ostream_t stream = pb_ostream_from_buffer(frame + header_bytes, NODE_FRAME_ROOM - header_bytes - crc_bytes);
  const bool encoded = pb_encode(&stream, spindle_twin_stream_Readings_fields, &node->message);
  empty(node);
  if (!encoded || stream.bytes_written == 0) return 0;
  ++node->sequence;
  frame[0] = 'S';
  frame[1] = 'T';
  frame[2] = 1; /* version */
  frame[3] = 0;
  put_big_endian((uint32_t)stream.bytes_written, 2, frame + 4);
  put_big_endian(node->sequence, 4, frame + 6);
  const size_t before_crc = header_bytes + stream.bytes_written;
  put_big_endian(crc32_of(frame, before_crc), crc_bytes, frame + before_crc);
  return before_crc + crc_bytes;
}

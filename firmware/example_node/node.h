/* A node that feeds the twin over its stream (firmware/acquire/stream.proto): what is the same on every machine. Needs
 * a C99 compiler and nanopb; no operating system, no heap, no clock of its own. Not for two threads at once. */
#ifndef SPINDLE_TWIN_EXAMPLE_NODE_H
#define SPINDLE_TWIN_EXAMPLE_NODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "firmware/acquire/stream.pb.h"

#define NODE_FRAME_ROOM (10 + 2048 + 4) /* bytes of the longest frame */

struct node {
  spindle_twin_stream_Readings message; /* what has been measured since the last frame */
  uint32_t sequence;                    /* of the last frame */
};

/* Before the first use, and after the connection was made anew. */
void node_start(struct node* node);

/* A value that was measured age_ms before the next frame; false: the frame is full. */
bool node_add(struct node* node, uint32_t channel, float value, uint32_t age_ms);

/* The next value of the one fast channel, interval_us after the one before; false: the frame is full. */
bool node_add_fast(struct node* node, uint32_t channel, float value, uint32_t interval_us);

/* Writes all that was added as one frame and begins a new one. Gives the frame's length, 0 if it cannot be encoded.
 * time_ms: of the node's own clock, which may start anywhere and wraps. */
size_t node_frame(struct node* node, uint32_t time_ms, uint8_t frame[NODE_FRAME_ROOM]);

#endif

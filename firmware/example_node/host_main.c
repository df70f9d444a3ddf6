/* spindle-twin-node ADDRESS PORT: the example node on a host, with made-up readings. On a microcontroller this file is
 * what changes: the clock, the converters and the network stack. Connects again after a second. */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "firmware/example_node/node.h"

enum { frame_ms = 100, fast_us = 1000, fast_channel = 10 };

static uint32_t clock_ms(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint32_t)((uint64_t)now.tv_sec * 1000u + (uint64_t)now.tv_nsec / 1000000u);
}

static void wait_ms(long ms) {
  const struct timespec time = {ms / 1000, ms % 1000 * 1000000};
  nanosleep(&time, NULL);
}

/* Channels 0 to 3: temperatures in degC; channel 10: load at 1 kHz, which ripples around 1. */
static void measure(struct node *node) {
  static const float temperatures_degC[] = {28.5f, 28.25f, 28.0f, 21.5f};
  for (uint32_t i = 0; i < 4; ++i) node_add(node, i, temperatures_degC[i], 0);
  for (int i = 0; i < frame_ms * 1000 / fast_us; ++i) node_add_fast(node, fast_channel, i % 2 ? 1.5f : 0.5f, fast_us);
}

static bool send_all(int connection, const uint8_t *bytes, size_t count) {
  while (count > 0) {
    const ssize_t sent = send(connection, bytes, count, 0);
    if (sent <= 0) return false;
    bytes += sent;
    count -= (size_t)sent;
  }
  return true;
}

int main(int argc, char **argv) {
  static struct node node;
  static uint8_t frame[NODE_FRAME_ROOM];
  struct sockaddr_in daemon = {.sin_family = AF_INET};
  if (argc != 3 || inet_pton(AF_INET, argv[1], &daemon.sin_addr) != 1 || atoi(argv[2]) < 1 || atoi(argv[2]) > 65535) {
    fprintf(stderr, "usage: %s ADDRESS PORT (IPv4, 1 to 65535)\n", argv[0]);
    return 2;
  }
  daemon.sin_port = htons((uint16_t)atoi(argv[2]));
  signal(SIGPIPE, SIG_IGN);
  for (;;) {
    const int connection = socket(AF_INET, SOCK_STREAM, 0);
    bool open = connection >= 0 && connect(connection, (const struct sockaddr *)&daemon, sizeof daemon) == 0;
    node_start(&node);
    while (open) {
      wait_ms(frame_ms);
      measure(&node);
      open = send_all(connection, frame, node_frame(&node, clock_ms(), frame));
    }
    if (connection >= 0) close(connection);
    wait_ms(1000);
  }
}

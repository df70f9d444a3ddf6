/* spindle-twin-client [ADDRESS [PORT [UNIT [SECONDS]]]]: the compensation as a control would follow it, a line each
 * second and at each other reason; without SECONDS until it is ended. In place of printing, a control hands `output` to
 * its own compensation. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "twin_compensation.h"
#include "twin_modbus.h"

enum { period_ms = 100, timeout_ms = 500, between_connects_ms = 1000, us_per_ms = 1000 };

static int64_t clock_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

/* Reads both blocks, or leaves the words as they are: then the heartbeat stands. */
static void read_words(struct twin_connection* connection, struct twin_input* input, const char* address,
                       uint16_t port) {
  static int64_t tried_us = -(int64_t)between_connects_ms * us_per_ms;
  const int64_t now_us = clock_us();
  if (connection->socket < 0) {
    if (now_us - tried_us < (int64_t)between_connects_ms * us_per_ms) return;
    tried_us = now_us;
    if (!twin_connect(connection, address, port, timeout_ms)) {
      fprintf(stderr, "%s:%u: no connection: %s\n", address, (unsigned)port, strerror(errno));
      return;
    }
  }
  if (!twin_read(connection, TWIN_HEAD_ADDRESS, TWIN_HEAD_COUNT, input->head, timeout_ms) ||
      !twin_read(connection, TWIN_ANSWER_ADDRESS, TWIN_ANSWER_COUNT, input->answer, timeout_ms)) {
    fprintf(stderr, "%s:%u: cannot read: %s\n", address, (unsigned)port, strerror(errno));
  }
}

static void print_line(const struct twin_output* output) {
  static const char* const reasons[] = TWIN_REASON_NAMES;
  printf("output_um=%.3f counts=%ld valid=%d settled=%d limited=%d lost=%d reason=%s\n", (double)output->output,
         (long)output->counts, output->valid, output->settled, output->limited, output->lost, reasons[output->reason]);
  fflush(stdout);
}

/* A whole number from `least` to `most`; ends the program where it is none. */
static long number(const char* text, const char* name, long least, long most) {
  char* end = NULL;
  errno = 0;
  const long value = strtol(text, &end, 10);
  if (errno != 0 || end == text || *end != '\0' || value < least || value > most) {
    fprintf(stderr, "%s: %s, allowed: %ld to %ld\n", name, text, least, most);
    exit(2);
  }
  return value;
}

int main(int count, char** arguments) {
  if (count > 5 || (count > 1 && arguments[1][0] == '-')) {
    fprintf(stderr, "usage: %s [ADDRESS [PORT [UNIT [SECONDS]]]]\n", arguments[0]);
    return 2;
  }
  const char* address = count > 1 ? arguments[1] : "127.0.0.1";
  const uint16_t port = (uint16_t)(count > 2 ? number(arguments[2], "PORT", 1, 65535) : 502);
  const uint8_t unit = (uint8_t)(count > 3 ? number(arguments[3], "UNIT", 0, 255) : 1);
  const long seconds = count > 4 ? number(arguments[4], "SECONDS", 1, INT_MAX) : 0;
  const struct twin_settings settings = TWIN_SETTINGS_DEFAULT;
  struct twin_compensation twin = {0};
  struct twin_input input = {.enable = true, .ready = true};
  struct twin_connection connection = {.socket = -1, .unit = unit};
  const int64_t begun_us = clock_us();
  int64_t before_us = begun_us, printed_s = -1;
  uint16_t printed_reason = 0;
  for (;;) {
    read_words(&connection, &input, address, port);
    const int64_t now_us = clock_us(), second = (now_us - begun_us) / 1000000;
    input.elapsed_us = (uint32_t)(now_us - before_us);
    before_us = now_us;
    twin_step(&twin, &settings, &input);
    if (second > printed_s || twin.output.reason != printed_reason) print_line(&twin.output);
    printed_s = second;
    printed_reason = twin.output.reason;
    if (seconds > 0 && second >= seconds) break;
    nanosleep(&(struct timespec){0, period_ms * 1000000L}, NULL);
  }
  twin_disconnect(&connection);
  return 0;
}

#define _POSIX_C_SOURCE 200809L
#include "twin_modbus.h"

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { read_input_registers = 4, header_bytes = 9, request_bytes = 12, most_registers = 125 };

static int64_t clock_ms(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* Whether the socket becomes ready before the end; errno says why not. */
static bool wait_for(int socket, short events, int64_t end_ms) {
  for (;;) {
    const int64_t left_ms = end_ms - clock_ms();
    struct pollfd waited = {socket, events, 0};
    const int ready = left_ms > 0 ? poll(&waited, 1, (int)left_ms) : 0;
    if (ready > 0) return true;
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) errno = ETIMEDOUT;
    return false;
  }
}

static bool send_all(int socket, const uint8_t* bytes, size_t count, int64_t end_ms) {
  while (count > 0) {
    const ssize_t sent = send(socket, bytes, count, MSG_NOSIGNAL);
    if (sent > 0) {
      bytes += sent;
      count -= (size_t)sent;
    } else if (sent < 0 && errno == EAGAIN) {
      if (!wait_for(socket, POLLOUT, end_ms)) return false;
    } else if (sent == 0 || errno != EINTR) {
      return false;
    }
  }
  return true;
}

static bool receive_all(int socket, uint8_t* bytes, size_t count, int64_t end_ms) {
  while (count > 0) {
    if (!wait_for(socket, POLLIN, end_ms)) return false;
    const ssize_t received = recv(socket, bytes, count, 0);
    if (received > 0) {
      bytes += received;
      count -= (size_t)received;
    } else if (received == 0) {
      errno = ECONNRESET;
      return false;
    } else if (errno != EINTR && errno != EAGAIN) {
      return false;
    }
  }
  return true;
}

static uint16_t word(const uint8_t* bytes) { return (uint16_t)(bytes[0] << 8 | bytes[1]); }

static void put_word(uint8_t* bytes, uint16_t value) {
  bytes[0] = (uint8_t)(value >> 8);
  bytes[1] = (uint8_t)value;
}

bool twin_connect(struct twin_connection* connection, const char* address, uint16_t port, int timeout_ms) {
  const struct addrinfo hints = {.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV, .ai_socktype = SOCK_STREAM};
  struct addrinfo* found = NULL;
  char service[6];
  const int64_t end_ms = clock_ms() + timeout_ms;
  connection->socket = -1;
  connection->transaction = 0;
  snprintf(service, sizeof service, "%u", (unsigned)port);
  if (getaddrinfo(address, service, &hints, &found) != 0) {
    errno = EINVAL;
    return false;
  }
  const int opened = socket(found->ai_family, SOCK_STREAM, 0);
  bool connected = opened >= 0 && fcntl(opened, F_SETFL, O_NONBLOCK) == 0 && fcntl(opened, F_SETFD, FD_CLOEXEC) == 0;
  if (connected && connect(opened, found->ai_addr, found->ai_addrlen) != 0) {
    int error = 0;
    socklen_t length = sizeof error;
    connected = errno == EINPROGRESS && wait_for(opened, POLLOUT, end_ms) &&
                getsockopt(opened, SOL_SOCKET, SO_ERROR, &error, &length) == 0;
    if (connected && error != 0) {
      errno = error;
      connected = false;
    }
  }
  freeaddrinfo(found);
  connection->socket = opened;
  if (!connected) {
    twin_disconnect(connection);
    return false;
  }
  const int on = 1;
  setsockopt(opened, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return true;
}

/* One request and its answer; `bytes` has room for the longest answer. */
static bool exchange(struct twin_connection* connection, uint16_t address, uint16_t count, uint8_t* bytes,
                     int64_t end_ms) {
  put_word(bytes, ++connection->transaction);
  put_word(bytes + 2, 0);
  put_word(bytes + 4, request_bytes - 6);
  bytes[6] = connection->unit;
  bytes[7] = read_input_registers;
  put_word(bytes + 8, address);
  put_word(bytes + 10, count);
  if (!send_all(connection->socket, bytes, request_bytes, end_ms)) return false;
  if (!receive_all(connection->socket, bytes, header_bytes, end_ms)) return false;
  const bool ours = word(bytes) == connection->transaction && word(bytes + 2) == 0 &&
                    word(bytes + 4) == 3 + 2 * count && bytes[6] == connection->unit &&
                    bytes[7] == read_input_registers && bytes[8] == 2 * count;
  if (!ours) {
    errno = EPROTO;
    return false;
  }
  return receive_all(connection->socket, bytes, 2u * count, end_ms);
}

bool twin_read(struct twin_connection* connection, uint16_t address, uint16_t count, uint16_t* words, int timeout_ms) {
  uint8_t bytes[2 * most_registers];
  if (connection->socket < 0 || count == 0 || count > most_registers) {
    errno = connection->socket < 0 ? ENOTCONN : EINVAL;
    return false;
  }
  if (!exchange(connection, address, count, bytes, clock_ms() + timeout_ms)) {
    twin_disconnect(connection);
    return false;
  }
  for (uint16_t n = 0; n < count; ++n) words[n] = word(bytes + 2 * n);
  return true;
}

void twin_disconnect(struct twin_connection* connection) {
  const int why = errno;
  if (connection->socket >= 0) close(connection->socket);
  connection->socket = -1;
  errno = why;
}

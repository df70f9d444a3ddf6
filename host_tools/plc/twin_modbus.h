/* Reads input registers by Modbus/TCP over POSIX sockets; waits no longer than it is told. */
#ifndef SPINDLE_TWIN_MODBUS_H
#define SPINDLE_TWIN_MODBUS_H

#include <stdbool.h>
#include <stdint.h>

struct twin_connection {
  int socket;           /* -1: none */
  uint8_t unit;         /* which spindle of the daemon; 1 where it has one */
  uint16_t transaction; /* of the last request */
};

/* Connects to a numeric IPv4 or IPv6 address within so many milliseconds; leaves the unit as it is. False: no
 * connection, errno says why. */
bool twin_connect(struct twin_connection* connection, const char* address, uint16_t port, int timeout_ms);

/* Reads `count` (1 to 125) registers from `address` (offset) on by FC4, within so many milliseconds. False: the words
 * are as they were, the connection is closed and errno says why (EPROTO: an exception, or no answer to this request).
 */
bool twin_read(struct twin_connection* connection, uint16_t address, uint16_t count, uint16_t* words, int timeout_ms);

/* Does nothing where there is no connection. */
void twin_disconnect(struct twin_connection* connection);

#endif

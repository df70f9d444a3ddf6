#pragma once

#include <string>

namespace spindle_twin::firmware {

/// A non-blocking listening TCP socket with a backlog of 128: a burst of clients at a machine's start is not turned
/// away. Throws rom::InputError naming `field`, address, port and reason.
int listen_on(const std::string& address, int port, const std::string& field = "serve");

int port_of(int socket);

/// Answers at once (TCP_NODELAY) and notices clients that are gone (keep-alive, about 25 s), so that power-cycled
/// controllers do not use up the connections.
void make_quick(int socket);

/// At most so many bytes, doubled by the kernel for its own book-keeping, wait for a peer that does not read; by itself
/// the kernel lets it grow to megabytes for each.
void limit_unread(int socket, int bytes);

}  // namespace spindle_twin::firmware

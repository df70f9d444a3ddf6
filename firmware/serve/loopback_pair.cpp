#include "firmware/serve/loopback_pair.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>

#include "firmware/serve/listen.hpp"

namespace spindle_twin::firmware {
namespace {

Descriptor loopback_listener() {
  Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool listening = socket.get() >= 0 &&
                         bind(socket.get(), reinterpret_cast<const sockaddr*>(&here), sizeof here) == 0 &&
                         listen(socket.get(), 8) == 0;
  return listening ? std::move(socket) : Descriptor();
}

/// The end that belongs to our own port; other programs of this computer may have been quicker.
Descriptor accept_from_port(int listener, int own_port) {
  constexpr int most_strangers = 8;
  for (int n = 0; n <= most_strangers; ++n) {
    pollfd come{listener, POLLIN, 0};
    sockaddr_in peer{};
    socklen_t size = sizeof peer;
    if (poll(&come, 1, 1000) != 1) break;
    Descriptor end(accept4(listener, reinterpret_cast<sockaddr*>(&peer), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (end.get() < 0 || ntohs(peer.sin_port) == own_port) return end;
  }
  errno = EBUSY;
  return Descriptor();
}

}  // namespace

std::optional<std::pair<Descriptor, Descriptor>> loopback_pair() {
  const Descriptor listener = loopback_listener();
  if (listener.get() < 0) return std::nullopt;
  sockaddr_in there{};
  socklen_t size = sizeof there;
  getsockname(listener.get(), reinterpret_cast<sockaddr*>(&there), &size);
  Descriptor one(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));  // connecting to a listener here does not wait
  if (one.get() < 0 || connect(one.get(), reinterpret_cast<const sockaddr*>(&there), sizeof there) != 0) {
    return std::nullopt;
  }
  Descriptor other = accept_from_port(listener.get(), port_of(one.get()));
  if (other.get() < 0 || fcntl(one.get(), F_SETFL, O_NONBLOCK) != 0) return std::nullopt;
  make_quick(one.get());
  make_quick(other.get());
  return std::pair(std::move(one), std::move(other));
}

}  // namespace spindle_twin::firmware

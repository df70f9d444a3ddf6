#include "firmware/serve/listen.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {

int listen_on(const std::string& address, int port, const std::string& field) {
  constexpr int backlog = 128;
  const int one = 1;
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<std::uint16_t>(port));
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const bool listening = fd >= 0 && inet_pton(AF_INET, address.c_str(), &here.sin_addr) == 1 &&
                         setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one) == 0 &&
                         bind(fd, reinterpret_cast<const sockaddr*>(&here), sizeof here) == 0 &&
                         listen(fd, backlog) == 0;
  if (listening) return fd;
  const int reason = errno;
  if (fd >= 0) close(fd);
  std::string text = "cannot listen on " + address + " port " + std::to_string(port) + ": " + std::strerror(reason);
  if (reason == EACCES) text += " (ports below 1024 need the capability CAP_NET_BIND_SERVICE)";
  throw rom::InputError({"", 0}, field, text);
}

int port_of(int socket) {
  sockaddr_in here{};
  socklen_t size = sizeof here;
  getsockname(socket, reinterpret_cast<sockaddr*>(&here), &size);
  return ntohs(here.sin_port);
}

void make_quick(int socket) {
  const auto set = [socket](int level, int option, int value) {
    setsockopt(socket, level, option, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 10);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 5);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
}

void limit_unread(int socket, int bytes) { setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes); }

}  // namespace spindle_twin::firmware

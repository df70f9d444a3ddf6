#include "tests/bench/bare_modbus_server.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <stdexcept>

namespace spindle_twin::bench {

int free_port() {
  const int probe = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof here;
  const bool known = bind(probe, reinterpret_cast<const sockaddr*>(&here), sizeof here) == 0 &&
                     getsockname(probe, reinterpret_cast<sockaddr*>(&here), &size) == 0;
  close(probe);
  if (!known) throw std::runtime_error("no port is free");
  return ntohs(here.sin_port);
}

BareModbusServer::BareModbusServer()
    : port_(free_port()),
      modbus_(modbus_new_tcp("127.0.0.1", port_)),
      mapping_(modbus_mapping_new(0, 0, 125, 125)),
      listener_(modbus_tcp_listen(modbus_, 1)) {
  if (mapping_ == nullptr || listener_ < 0) throw std::runtime_error("libmodbus does not listen");
}

BareModbusServer::~BareModbusServer() {
  close(listener_);
  modbus_mapping_free(mapping_);
  modbus_free(modbus_);
}

pid_t BareModbusServer::start() {
  const pid_t pid = fork();
  if (pid == 0) {
    serve();
    _exit(0);
  }
  return pid;
}

void BareModbusServer::serve() {
  std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> request{};
  if (modbus_tcp_accept(modbus_, &listener_) < 0) return;
  for (int size = 0; size >= 0;) {
    size = modbus_receive(modbus_, request.data());
    if (size > 0) modbus_reply(modbus_, request.data(), size, mapping_);
  }
}

}  // namespace spindle_twin::bench

#include "host_tools/virtual_spindle/plant_server.hpp"

#include <arpa/inet.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr std::size_t mbap_start = 6;  // bytes before those that the MBAP length counts
constexpr std::size_t longest_frame = 260;
constexpr std::size_t client_limit = 32;
constexpr int tick_ms = 100;
constexpr std::uint8_t read_holding_registers = 3;
constexpr std::uint8_t read_input_registers = 4;

}  // namespace

struct PlantServer::Client {
  int socket = -1;
  std::array<std::uint8_t, longest_frame> bytes{};
  std::size_t filled = 0;
  bool close = false;
};

PlantServer::PlantServer(const std::string& address, int port)
    : context_(modbus_new_tcp(address.c_str(), port), &modbus_free) {
  in_addr parsed{};  // libmodbus takes what is no address for 255.255.255.255, and listens
  if (::inet_pton(AF_INET, address.c_str(), &parsed) != 1) {
    throw rom::InputError({}, "--address", "must be an IPv4 address such as 127.0.0.1, is '" + address + "'");
  }
  const std::string place = address + ":" + std::to_string(port);
  if (!context_) throw rom::InputError({}, "--port", place + ": " + modbus_strerror(errno));
  listener_ = modbus_tcp_listen(context_.get(), 64);
  if (listener_ < 0) throw rom::InputError({}, "--port", "cannot listen on " + place + ": " + modbus_strerror(errno));
  // libmodbus sleeps this long before an exception reply; the default of 500 ms would hold up every client.
  modbus_set_response_timeout(context_.get(), 0, 1);
}

PlantServer::~PlantServer() {
  if (listener_ >= 0) ::close(listener_);
}

void PlantServer::publish(const PlantRegisters& registers) {
  const std::lock_guard lock(mutex_);
  registers_ = registers;
}

void PlantServer::answer(Client& client) {
  const ssize_t got =
      ::recv(client.socket, client.bytes.data() + client.filled, client.bytes.size() - client.filled, MSG_DONTWAIT);
  if (got <= 0) {
    client.close = got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
    return;
  }
  client.filled += static_cast<std::size_t>(got);
  while (client.filled >= mbap_start) {
    const std::size_t length = mbap_start + static_cast<std::size_t>(client.bytes[4] << 8 | client.bytes[5]);
    if (length > longest_frame || length < mbap_start + 2) {
      client.close = true;
      return;
    }
    if (client.filled < length) return;
    const std::uint8_t function = client.bytes[mbap_start + 1];
    if ((function == read_holding_registers || function == read_input_registers) && length != mbap_start + 6) {
      client.close = true;
      return;
    }
    // modbus_mapping_t wants writable tables; both codes show one copy, and nothing else reaches it.
    PlantRegisters copy;
    {
      const std::lock_guard lock(mutex_);
      copy = registers_;
    }
    modbus_mapping_t mapping{};
    mapping.nb_registers = mapping.nb_input_registers = plant_register_count;
    mapping.tab_registers = mapping.tab_input_registers = copy.data();
    modbus_set_socket(context_.get(), client.socket);
    const bool readable = function == read_holding_registers || function == read_input_registers;
    const int sent =
        readable ? modbus_reply(context_.get(), client.bytes.data(), static_cast<int>(length), &mapping)
                 : modbus_reply_exception(context_.get(), client.bytes.data(), MODBUS_EXCEPTION_ILLEGAL_FUNCTION);
    if (sent < 0) {
      client.close = true;
      return;
    }
    was_read_ = was_read_ || readable;
    std::copy(client.bytes.begin() + static_cast<std::ptrdiff_t>(length),
              client.bytes.begin() + static_cast<std::ptrdiff_t>(client.filled), client.bytes.begin());
    client.filled -= length;
  }
}

void PlantServer::serve(const std::atomic<bool>& stop) {
  std::vector<Client> clients;
  std::vector<pollfd> watched;
  while (!stop) {
    watched.assign(1, {listener_, POLLIN, 0});
    for (const Client& client : clients) watched.push_back({client.socket, POLLIN, 0});
    if (::poll(watched.data(), watched.size(), tick_ms) <= 0) continue;
    for (std::size_t c = 0; c < clients.size(); ++c) {
      if (watched[c + 1].revents != 0) answer(clients[c]);
    }
    for (const Client& client : clients) {
      if (client.close) ::close(client.socket);
    }
    std::erase_if(clients, [](const Client& client) { return client.close; });
    if ((watched[0].revents & POLLIN) == 0) continue;
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket < 0) continue;
    if (clients.size() >= client_limit) {
      ::close(socket);
      continue;
    }
    const timeval patience{1, 0};  // a client that does not read its answers is dropped
    ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    Client client;
    client.socket = socket;
    clients.push_back(client);
  }
  for (const Client& client : clients) ::close(client.socket);
}

}  // namespace spindle_twin::host_tools

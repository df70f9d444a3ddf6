#include "firmware/serve/tls_front.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <new>
#include <optional>
#include <utility>

#include "firmware/serve/listen.hpp"
#include "firmware/serve/loopback_pair.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr std::int64_t handshake_ns = 5 * ns_per_s;
constexpr int most_handshakes = 16;          ///< at once, beside the connections of the server
constexpr int most_handshakes_per_host = 4;  ///< of these
constexpr int unread_by_tls_bytes = 16384;   ///< as the server allows

std::unique_ptr<TlsIdentity> identity_of(const TlsPlan& plan) {
  try {
    return std::make_unique<TlsIdentity>(plan);
  } catch (const TlsFileError& error) {
    throw rom::InputError({"", 0}, "serve.tls." + error.key, error.what());
  }
}

}  // namespace

TlsFront::TlsFront(const ServePlan& plan, Clock& clock, ModbusServer& server)
    : plan_(plan),
      tls_(plan.tls.value()),
      clock_(clock),
      server_(server),
      identity_(identity_of(tls_)),
      read_(stamps()),
      acceptor_(Descriptor(listen_on(tls_.address, tls_.port, "serve.tls")), plan.allow, clock, "server by TLS",
                "serve.allow"),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (wake_.get() < 0) throw std::bad_alloc();
}

int TlsFront::port() const { return acceptor_.port(); }

void TlsFront::stop() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_.get(), &one, sizeof one);
}

int TlsFront::poll_timeout_ms() const {
  std::int64_t first_ns = acceptor_.rests_until_ns();
  for (const auto& link : links_) {
    const std::int64_t end_ns = link->deadline_ns();
    if (end_ns != 0 && (first_ns == 0 || end_ns < first_ns)) first_ns = end_ns;
  }
  if (first_ns == 0) return -1;
  return static_cast<int>(std::max<std::int64_t>(0, (first_ns - clock_.now_ns()) / 1'000'000 + 1));
}

void TlsFront::run() {
  std::vector<pollfd> polled;
  constexpr std::size_t first_link = 2;
  while (true) {
    polled.clear();
    polled.push_back({wake_.get(), POLLIN, 0});
    polled.push_back(acceptor_.polled());
    for (const auto& link : links_) {
      polled.push_back({link->client(), link->client_events(), 0});
      polled.push_back({link->server(), link->server_events(), 0});
    }
    if (poll(polled.data(), polled.size(), poll_timeout_ms()) < 0 && errno != EINTR) {
      acceptor_.rest_behind_failed_poll(errno);
      for (pollfd& each : polled) each.revents = 0;
    }
    if (polled[0].revents != 0) return;
    for (std::size_t l = 0; l < links_.size(); ++l) {
      TlsLink& link = *links_[l];
      const short client = polled[first_link + 2 * l].revents;
      const short server = polled[first_link + 2 * l + 1].revents;
      if ((server & (POLLRDHUP | POLLHUP | POLLERR)) != 0) link.note_leaving_server(clock_.now_ns());
      if (client != 0 || server != 0) look_at(link);
      // A client that is gone is reported for as long as it is there, whatever one waits for.
      if ((client & (POLLERR | POLLHUP | POLLNVAL)) != 0) link.end();
      if (link.deadline_ns() != 0 && clock_.now_ns() >= link.deadline_ns()) link.end();
    }
    std::erase_if(links_, [](const auto& link) { return link->over(); });
    if (polled[1].revents != 0) accept_all();
  }
}

/// Why a client of this address gets no handshake; null: it does.
const char* TlsFront::refusal_of(std::uint32_t host) const {
  const auto handshakes = [&](bool of_host) {
    return std::count_if(links_.begin(), links_.end(),
                         [&](const auto& link) { return !link->joined() && (!of_host || link->host() == host); });
  };
  if (handshakes(true) >= most_handshakes_per_host) return "too many of its handshakes have begun";
  if (handshakes(false) >= most_handshakes) return "too many handshakes have begun";
  return std::ssize(links_) >= plan_.connections + most_handshakes ? "too many connections are open" : nullptr;
}

void TlsFront::accept_all() {
  while (auto client = acceptor_.next()) {
    const std::int64_t now_ns = clock_.now_ns();
    if (const char* const why = refusal_of(client->host)) {
      const auto before = refusals_.pass(now_ns);
      if (before) {
        spdlog::warn("client {} by TLS refused: {}{}", address_text(client->host), why, LogLimit::also(*before));
      }
      continue;
    }
    limit_unread(client->socket.get(), unread_by_tls_bytes);
    renew_identity();
    TlsSession session = identity_->session(client->socket.get());
    links_.push_back(
        std::make_unique<TlsLink>(std::move(client->socket), std::move(session), client->host, now_ns + handshake_ns));
  }
}

void TlsFront::look_at(TlsLink& link) {
  if (link.joined()) return link.move_bytes(clock_.now_ns());
  switch (link.shake_hands()) {
    case TlsLink::Handshake::goes_on:
      return;
    case TlsLink::Handshake::done:
      return begin(link);
    case TlsLink::Handshake::failed:
      const std::string why = why_refused(link.session());
      const auto before = handshakes_.pass(clock_.now_ns());
      if (before) {
        spdlog::warn("client {} by TLS refused: {}{}", address_text(link.host()), why, LogLimit::also(*before));
      }
  }
}

/// The client has shown who it is: from here on the server has it.
void TlsFront::begin(TlsLink& link) {
  auto pair = loopback_pair();
  if (!pair) {
    const int reason = errno;
    const auto before = troubles_.pass(clock_.now_ns());
    if (before) {
      spdlog::error("server by TLS: no way to the server: {}{}", std::strerror(reason), LogLimit::also(*before));
    }
    return link.end();
  }
  const std::optional<std::string> role = role_of(link.session());
  const auto& roles = tls_.write_roles;
  const bool role_writes = !roles || (role && std::find(roles->begin(), roles->end(), *role) != roles->end());
  const bool may_write = role_writes && is_allowed(plan_.write, link.host());
  if (const auto before = guests_.pass(clock_.now_ns())) {
    spdlog::info("client {} by TLS: {}, {}, {}{}", address_text(link.host()), subject_of(link.session()),
                 role ? "role " + *role : "no role", may_write ? "may write" : "reads only", LogLimit::also(*before));
  }
  link.join(std::move(pair->first));
  server_.adopt(std::move(pair->second), link.host(), may_write);
  link.move_bytes(clock_.now_ns());  // it may have asked already
}

TlsFront::Stamps TlsFront::stamps() const {
  Stamps found{};
  const std::array<const std::string*, std::tuple_size_v<Stamps>> paths{&tls_.certificate, &tls_.key, &tls_.clients_ca,
                                                                        &tls_.revoked};
  for (std::size_t p = 0; p < paths.size(); ++p) {
    struct stat file {};
    if (paths[p]->empty() || stat(paths[p]->c_str(), &file) != 0) continue;
    found[p] = {file.st_mtim.tv_sec * ns_per_s + file.st_mtim.tv_nsec, file.st_size, file.st_ino};
  }
  return found;
}

/// Certificates last a year or less and a twin runs for years: files that are replaced are read again. What cannot be
/// used changes nothing, and is tried again when it changes.
void TlsFront::renew_identity() {
  const Stamps now = stamps();
  if (now == read_) return;
  read_ = now;
  try {
    identity_ = std::make_unique<TlsIdentity>(tls_);
    spdlog::info("serve.tls: files have changed and are read; the certificate is valid until {}",
                 identity_->valid_until());
  } catch (const TlsFileError& error) {
    spdlog::error("serve.tls.{}: {}; what was read before still counts", error.key, error.what());
  }
}

}  // namespace spindle_twin::firmware

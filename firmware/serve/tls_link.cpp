#include "firmware/serve/tls_link.hpp"

#include <openssl/err.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <utility>

#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {
namespace {

/// Of one client in one turn, so that a busy one leaves time for the others.
constexpr int most_records = 4;
constexpr std::int64_t taken_within_ns = 10 * ns_per_s;

}  // namespace

TlsLink::TlsLink(Descriptor client, TlsSession session, std::uint32_t host, std::int64_t deadline_ns)
    : client_(std::move(client)),
      session_(std::move(session)),
      host_(host),
      deadline_ns_(deadline_ns),
      read_waits_for_(POLLIN),
      write_waits_for_(POLLOUT) {}

TlsLink::Handshake TlsLink::shake_hands() {
  ERR_clear_error();
  errno = 0;
  const int result = SSL_accept(session_.get());
  if (result == 1) {
    deadline_ns_ = 0;
    read_waits_for_ = POLLIN;
    return Handshake::done;
  }
  read_waits_for_ = wanted(result);
  return over_ ? Handshake::failed : Handshake::goes_on;
}

void TlsLink::join(Descriptor server) { server_ = std::move(server); }

/// What OpenSSL waits for; the link is over where it waits for nothing.
short TlsLink::wanted(int result) {
  switch (SSL_get_error(session_.get(), result)) {
    case SSL_ERROR_WANT_READ:
      return POLLIN;
    case SSL_ERROR_WANT_WRITE:
      return POLLOUT;
    default:
      over_ = true;
      return 0;
  }
}

short TlsLink::client_events() const {
  if (!joined()) return read_waits_for_;
  const int reading = up_.empty() && !server_ended_ ? read_waits_for_ : 0;
  return static_cast<short>(reading | (down_.empty() ? 0 : write_waits_for_));
}

short TlsLink::server_events() const {
  if (server_ended_) return 0;
  return static_cast<short>((up_.empty() ? 0 : POLLOUT) | (down_.empty() ? POLLIN : 0) |
                            (server_leaves_ ? 0 : POLLRDHUP));
}

bool TlsLink::read_client() {
  if (!up_.empty() || server_ended_) return false;
  ERR_clear_error();
  const auto room = up_.room();
  const int got = SSL_read(session_.get(), room.data(), static_cast<int>(room.size()));
  if (got > 0)
    up_.filled(static_cast<std::size_t>(got));
  else
    read_waits_for_ = wanted(got);
  return got > 0;
}

/// What the client does not take within a second, it does not get.
void TlsLink::note_end_of_server(std::int64_t now_ns) {
  note_leaving_server(now_ns);
  server_ended_ = true;
}

void TlsLink::note_leaving_server(std::int64_t now_ns) {
  if (server_leaves_ || server_ended_) return;
  server_leaves_ = true;
  deadline_ns_ = now_ns + ns_per_s;
}

bool TlsLink::write_server(std::int64_t now_ns) {
  if (up_.empty() || server_ended_) return false;
  const ssize_t sent = send(server_.get(), up_.rest().data(), up_.rest().size(), MSG_NOSIGNAL);
  if (sent > 0) up_.taken(static_cast<std::size_t>(sent));
  if (sent < 0 && errno != EAGAIN && errno != EINTR) note_end_of_server(now_ns);
  return sent > 0;
}

bool TlsLink::read_server(std::int64_t now_ns) {
  if (!down_.empty() || server_ended_) return false;
  const auto room = down_.room();
  const ssize_t got = recv(server_.get(), room.data(), room.size(), 0);
  if (got > 0) down_.filled(static_cast<std::size_t>(got));
  if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) note_end_of_server(now_ns);
  return got > 0;
}

/// A server that leaves is not seen behind what it has said, as long as that is not taken: so there is a deadline, too.
bool TlsLink::write_client(std::int64_t now_ns) {
  if (down_.empty()) return false;
  ERR_clear_error();
  const int sent = SSL_write(session_.get(), down_.rest().data(), static_cast<int>(down_.rest().size()));
  if (sent > 0) {
    down_.taken(static_cast<std::size_t>(sent));
    if (!server_leaves_) deadline_ns_ = 0;
    return true;
  }
  write_waits_for_ = wanted(sent);
  if (deadline_ns_ == 0) deadline_ns_ = now_ns + taken_within_ns;
  return false;
}

void TlsLink::move_bytes(std::int64_t now_ns) {
  for (int n = 0; n < most_records && !over_; ++n) {
    bool moved = read_client();
    moved |= write_server(now_ns);
    moved |= read_server(now_ns);
    moved |= write_client(now_ns);
    if (server_ended_ && down_.empty()) return end();
    if (!moved) return;
  }
}

void TlsLink::end() {
  ERR_clear_error();
  if (!over_ && SSL_is_init_finished(session_.get()) != 0) SSL_shutdown(session_.get());
  ERR_clear_error();
  over_ = true;
}

}  // namespace spindle_twin::firmware

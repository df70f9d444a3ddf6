#include "firmware/serve/acceptor.hpp"

#include <netinet/in.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "firmware/serve/listen.hpp"

namespace spindle_twin::firmware {
namespace {

/// Orders, checkpoint, history and parameters are written through descriptors of their own, two at a time; and the
/// device is dialled again.
constexpr int kept_for_files = 8;

/// Descriptors are given from the lowest: after this one so few are left that a file could not be opened.
bool crowds_out_files(int descriptor) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return false;
  return static_cast<rlim_t>(descriptor) + kept_for_files >= limit.rlim_cur;
}

}  // namespace

Acceptor::Acceptor(Descriptor listener, std::vector<AddressRange> allow, Clock& clock, std::string name,
                   std::string allow_key)
    : listener_(std::move(listener)),
      allow_(std::move(allow)),
      clock_(clock),
      name_(std::move(name)),
      allow_key_(std::move(allow_key)) {}

int Acceptor::port() const { return listener_.get() < 0 ? 0 : port_of(listener_.get()); }

pollfd Acceptor::polled() {
  if (rests_until_ns_ != 0 && clock_.now_ns() >= rests_until_ns_) rests_until_ns_ = 0;
  return {listener_.get(), static_cast<short>(rests_until_ns_ == 0 ? POLLIN : 0), 0};
}

std::optional<Acceptor::Client> Acceptor::next() {
  while (true) {
    sockaddr_in peer{};
    socklen_t size = sizeof peer;
    Descriptor socket(
        accept4(listener_.get(), reinterpret_cast<sockaddr*>(&peer), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.get() < 0) {
      wait_for_descriptors(errno);
      return std::nullopt;
    }
    const std::uint32_t host = ntohl(peer.sin_addr.s_addr);
    if (!is_allowed(allow_, host)) {
      const auto before = strangers_.pass(clock_.now_ns());
      if (before) spdlog::warn("client {} is not in {}{}", address_text(host), allow_key_, LogLimit::also(*before));
    } else if (crowds_out_files(socket.get())) {
      const auto before = refusals_.pass(clock_.now_ns());
      if (before) {
        spdlog::warn("{}: client {} refused: the last file descriptors are kept for orders and checkpoint{}", name_,
                     address_text(host), LogLimit::also(*before));
      }
    } else {
      make_quick(socket.get());
      return Client{std::move(socket), host};
    }
  }
}

/// Accepting goes on when others may have closed theirs; what waits is in the backlog.
void Acceptor::wait_for_descriptors(int reason) {
  if (reason != EMFILE && reason != ENFILE && reason != ENOBUFS && reason != ENOMEM) return;
  rests_until_ns_ = clock_.now_ns() + ns_per_s;
  const auto before = troubles_.pass(clock_.now_ns());
  if (before)
    spdlog::error("{}: no client can be accepted: {}{}", name_, std::strerror(reason), LogLimit::also(*before));
}

void Acceptor::rest_behind_failed_poll(int reason) {
  const auto before = troubles_.pass(clock_.now_ns());
  if (before) spdlog::error("{}: poll: {}{}", name_, std::strerror(reason), LogLimit::also(*before));
  clock_.sleep_until_ns(clock_.now_ns() + ns_per_s / 10);
}

}  // namespace spindle_twin::firmware

#include "firmware/serve/tls_link.hpp"

#include <gtest/gtest.h>
#include <openssl/err.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "firmware/serve/loopback_pair.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace serve_tls_link_test {

constexpr std::int64_t second_ns = 1'000'000'000;

/// A client by OpenSSL, the link under test, and the Modbus server's end behind it, all in this thread.
class Link : public ::testing::Test {
 protected:
  Link() : context_(SSL_CTX_new(TLS_client_method())) {
    const std::string pem = folder_.file("own.pem"), key = folder_.file("own.key");
    const std::string make =
        "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=own -keyout " + key + " -out " +
        pem + " 2>/dev/null && chmod 600 " + key;
    EXPECT_EQ(std::system(make.c_str()), 0);  // NOLINT(cert-env33-c): the program that the page for users names
    TlsPlan plan;
    plan.certificate = plan.clients_ca = pem;
    plan.key = key;
    identity_.emplace(plan);
    SSL_CTX_use_certificate_chain_file(context_.get(), pem.c_str());
    SSL_CTX_use_PrivateKey_file(context_.get(), key.c_str(), SSL_FILETYPE_PEM);
    auto outside = loopback_pair();
    client_end_ = std::move(outside->first);
    const int socket = outside->second.get();
    link_.emplace(std::move(outside->second), identity_->session(socket), 0x7f000001U, second_ns);
    client_.reset(SSL_new(context_.get()));
    SSL_set_fd(client_.get(), client_end_.get());
    SSL_set_connect_state(client_.get());
  }

  /// The kernel passes on bytes, and room for more, when it comes to it: so both ends take their turns until `done`,
  /// for thirty seconds at most.
  template <class Done>
  static bool turns_until(Done done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    for (;;) {
      if (done()) return true;
      if (std::chrono::steady_clock::now() > end) return false;
    }
  }

  void shake_hands() {
    TlsLink::Handshake server = TlsLink::Handshake::goes_on;
    turns_until([&] {
      SSL_do_handshake(client_.get());
      server = link_->shake_hands();
      return server != TlsLink::Handshake::goes_on;
    });
    ASSERT_EQ(server, TlsLink::Handshake::done);
    EXPECT_EQ(link_->deadline_ns(), 0);
    auto inside = loopback_pair();
    server_end_ = std::move(inside->first);
    link_->join(std::move(inside->second));
  }

  /// Left alone, a kernel keeps for who does not read as many megabytes as it is set to.
  void let_sockets_hold_little() {
    const int bytes = 32768;
    for (const int end : {client_end_.get(), link_->client(), link_->server(), server_end_.get()}) {
      ASSERT_EQ(setsockopt(end, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes), 0);
      ASSERT_EQ(setsockopt(end, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes), 0);
    }
  }

  /// As much as goes now, in a portion of random length.
  void client_writes(std::string& rest) {
    if (rest.empty()) return;
    const int sent = SSL_write(client_.get(), rest.data(), static_cast<int>(portion(rest.size())));
    if (sent > 0) rest.erase(0, static_cast<std::size_t>(sent));
    ERR_clear_error();
  }
  void client_reads(std::string& got) {
    std::array<char, 20000> room{};
    const int read = SSL_read(client_.get(), room.data(), static_cast<int>(portion(room.size())));
    if (read > 0) got.append(room.data(), static_cast<std::size_t>(read));
    ERR_clear_error();
  }
  void server_writes(std::string& rest) {
    if (rest.empty()) return;
    const ssize_t sent = send(server_end_.get(), rest.data(), portion(rest.size()), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) rest.erase(0, static_cast<std::size_t>(sent));
  }
  void server_reads(std::string& got) {
    std::array<char, 20000> room{};
    const ssize_t read = recv(server_end_.get(), room.data(), portion(room.size()), MSG_DONTWAIT);
    if (read > 0) got.append(room.data(), static_cast<std::size_t>(read));
  }
  std::size_t portion(std::size_t most) { return 1 + random_() % std::min<std::size_t>(most, 20000); }
  std::string bytes(std::size_t count) {
    std::string all(count, '\0');
    for (char& each : all) each = static_cast<char>(random_());
    return all;
  }

  struct Free {
    void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
  };
  tests::TemporaryFolder folder_;
  std::unique_ptr<SSL_CTX, Free> context_;
  std::optional<TlsIdentity> identity_;
  std::optional<TlsLink> link_;
  Descriptor client_end_, server_end_;
  TlsSession client_;
  std::mt19937 random_{20261123};
};

TEST_F(Link, bytes_come_through_unchanged_both_ways_in_whatever_portions_they_are_moved) {
  shake_hands();
  const std::string asked = bytes(300'000), answered = bytes(300'000);
  std::string to_send = asked, to_answer = answered, got, answer;
  const bool through = turns_until([&] {
    switch (random_() % 5) {
      case 0:
        client_writes(to_send);
        break;
      case 1:
        server_writes(to_answer);
        break;
      case 2:
        client_reads(answer);
        break;
      case 3:
        server_reads(got);
        break;
      default:
        link_->move_bytes(0);
    }
    return link_->over() || (got.size() == asked.size() && answer.size() == answered.size());
  });
  EXPECT_TRUE(through);
  EXPECT_FALSE(link_->over());
  EXPECT_TRUE(got == asked);
  EXPECT_TRUE(answer == answered);
}

TEST_F(Link, who_does_not_read_is_not_read) {
  shake_hands();
  let_sockets_hold_little();
  std::string flood = bytes(4'000'000);
  for (int n = 0; n < 10'000; ++n) {
    server_writes(flood);
    link_->move_bytes(0);
  }
  EXPECT_GT(flood.size(), 3'000'000U) << "what two sockets hold, and a record";
  EXPECT_EQ(link_->server_events() & POLLIN, 0);
  EXPECT_EQ(link_->client_events() & POLLOUT, POLLOUT);
  std::string got;
  const bool goes_on = turns_until([&] {
    client_reads(got);
    link_->move_bytes(0);
    return (link_->server_events() & POLLIN) != 0;
  });
  EXPECT_TRUE(goes_on) << "where there is room again";
}

/// Else poll() would return at once for as long as nothing can be moved.
TEST_F(Link, each_side_is_waited_for_only_where_something_can_be_moved) {
  shake_hands();
  let_sockets_hold_little();
  EXPECT_EQ(link_->client_events(), POLLIN);
  EXPECT_EQ(link_->server_events(), POLLIN | POLLRDHUP);
  std::string asked = bytes(4'000'000), answered = bytes(4'000'000);
  for (int n = 0; n < 4'000; ++n) {
    client_writes(asked);
    link_->move_bytes(0);
  }
  EXPECT_EQ(link_->client_events(), 0) << "the server takes nothing more";
  EXPECT_EQ(link_->server_events(), POLLIN | POLLOUT | POLLRDHUP);
  for (int n = 0; n < 4'000; ++n) {
    server_writes(answered);
    link_->move_bytes(0);
  }
  EXPECT_EQ(link_->client_events(), POLLOUT) << "nor does the client";
  EXPECT_EQ(link_->server_events(), POLLOUT | POLLRDHUP);
  link_->note_leaving_server(7 * second_ns);
  EXPECT_EQ(link_->server_events(), POLLOUT);
  EXPECT_GE(link_->server(), 0) << "it may still be told something";
}

TEST_F(Link, a_client_that_says_good_bye_ends_it) {
  shake_hands();
  SSL_shutdown(client_.get());
  EXPECT_TRUE(turns_until([&] {
    link_->move_bytes(0);
    return link_->over();
  }));
}

TEST_F(Link, who_is_ended_hears_a_good_bye) {
  shake_hands();
  link_->end();
  EXPECT_TRUE(link_->over());
  std::string got;
  EXPECT_TRUE(turns_until([&] {
    client_reads(got);
    return (SSL_get_shutdown(client_.get()) & SSL_RECEIVED_SHUTDOWN) != 0;
  }));
  EXPECT_EQ(got, "");
}

TEST_F(Link, an_end_of_the_server_ends_it_behind_the_last_bytes) {
  shake_hands();
  std::string last = bytes(1000), got;
  const std::string sent = last;
  while (!last.empty()) server_writes(last);
  server_end_ = Descriptor();
  const bool ends = turns_until([&] {
    link_->move_bytes(5 * second_ns);
    return link_->over();
  });
  EXPECT_TRUE(ends);
  const bool says_good_bye = turns_until([&] {
    client_reads(got);
    return (SSL_get_shutdown(client_.get()) & SSL_RECEIVED_SHUTDOWN) != 0;
  });
  EXPECT_TRUE(says_good_bye);
  EXPECT_TRUE(got == sent);
}

/// Else who shows a certificate and never reads would hold its place for ever: the end of a server that leaves stands
/// behind what is not taken.
TEST_F(Link, a_client_that_takes_nothing_has_ten_seconds) {
  shake_hands();
  let_sockets_hold_little();
  std::string flood = bytes(4'000'000), got;
  // The kernel now and then finds room for more, by timers of its own: then ten seconds begin anew. Where it takes
  // nothing, they go on from the first time that it refused.
  std::int64_t now_ns = 7 * second_ns, deadline_ns = 0;
  int rounds_without = 0;
  for (int round = 0; round < 100 && rounds_without < 3; ++round, now_ns += 2 * second_ns) {
    for (int n = 0; n < 2'000; ++n) {
      server_writes(flood);
      link_->move_bytes(now_ns);
    }
    rounds_without = link_->deadline_ns() == deadline_ns ? rounds_without + 1 : 0;
    if (rounds_without == 0) {
      ASSERT_EQ(link_->deadline_ns(), now_ns + 10 * second_ns);
    }
    deadline_ns = link_->deadline_ns();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(rounds_without, 3) << "each refusal has begun the ten seconds anew";
  const bool forgotten = turns_until([&] {
    client_reads(got);
    link_->move_bytes(now_ns);
    return link_->deadline_ns() == 0;
  });
  EXPECT_TRUE(forgotten) << "it reads again";
}

/// Of a broken connection poll() would tell at once and always.
TEST_F(Link, a_server_that_breaks_off_leaves_the_client_a_second_and_is_asked_nothing_more) {
  shake_hands();
  let_sockets_hold_little();
  std::string flood = bytes(4'000'000), unread = bytes(100);
  for (int n = 0; n < 2'000; ++n) {
    server_writes(flood);
    client_writes(unread);
    link_->move_bytes(0);
  }
  server_end_ = Descriptor();  // with unread bytes: a reset
  pollfd polled{link_->server(), link_->server_events(), 0};
  ASSERT_EQ(poll(&polled, 1, 1000), 1);
  EXPECT_NE(polled.revents & (POLLHUP | POLLERR), 0);
  link_->note_leaving_server(7 * second_ns);
  link_->move_bytes(7 * second_ns);
  link_->note_leaving_server(7 * second_ns + 1);
  EXPECT_FALSE(link_->over());
  EXPECT_EQ(link_->deadline_ns(), 8 * second_ns);
  EXPECT_EQ(link_->server(), -1);
}

TEST_F(Link, a_client_that_speaks_no_tls_fails_and_one_that_says_nothing_goes_on_until_its_deadline) {
  EXPECT_EQ(link_->shake_hands(), TlsLink::Handshake::goes_on);
  EXPECT_EQ(link_->deadline_ns(), second_ns);
  EXPECT_EQ(link_->client_events(), POLLIN);
  const std::string modbus("\x00\x01\x00\x00\x00\x06\x01\x04\x00\x00\x00\x02", 12);
  ASSERT_EQ(send(client_end_.get(), modbus.data(), modbus.size(), MSG_NOSIGNAL), 12);
  TlsLink::Handshake made = TlsLink::Handshake::goes_on;
  turns_until([&] {
    made = link_->shake_hands();
    return made != TlsLink::Handshake::goes_on;
  });
  EXPECT_EQ(made, TlsLink::Handshake::failed);
  EXPECT_TRUE(link_->over());
}

}  // namespace serve_tls_link_test
}  // namespace spindle_twin::firmware

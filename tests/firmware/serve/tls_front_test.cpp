#include "firmware/serve/tls_front.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "rom/read/input_error.hpp"
#include "tests/firmware/support/http_serving.hpp"
#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/serving.hpp"
#include "tests/firmware/support/standing_clock.hpp"
#include "tests/support/temporary_folder.hpp"

/// Clients that never end their handshake, on a clock that stands.
namespace spindle_twin::firmware {
namespace serve_tls_front_test {

using http_serving::Client;

constexpr std::uint32_t host_a = INADDR_LOOPBACK;  ///< those behind it are other hosts
constexpr std::uint32_t stranger_host = INADDR_LOOPBACK + 0x10000;

class Front : public ::testing::Test {
 protected:
  Front() {
    const std::string pem = folder_.file("own.pem"), key = folder_.file("own.key");
    const std::string make =
        "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=own -keyout " + key + " -out " +
        pem + " 2>/dev/null && chmod 600 " + key;
    EXPECT_EQ(std::system(make.c_str()), 0);  // NOLINT(cert-env33-c): the program that the page for users names
    plan_.allow = {*parse_address_range("127.0.0.0/16")};
    plan_.tls.emplace();
    plan_.tls->port = 0;
    plan_.tls->certificate = plan_.tls->clients_ca = pem;
    plan_.tls->key = key;
    front_ = std::make_unique<TlsFront>(plan_, clock_, behind_.server);
    thread_ = std::thread([this] { front_->run(); });
  }
  ~Front() override {
    front_->stop();
    thread_.join();
  }

  /// One whose handshake has begun, and goes on for as long as it is let.
  struct Slow : Client {
    Slow(int port, std::uint32_t from) : Client(port, from) { send("\x16"); }
  };
  /// The front has looked at all that was there before, at the time that it is now: it has turned a stranger away.
  void look() {
    Client stranger(front_->port(), stranger_host);
    EXPECT_TRUE(stranger.is_ended());
  }
  bool is_taken(std::uint32_t from) {
    clients_.emplace_back(front_->port(), from);
    look();
    return clients_.back().hears_nothing();
  }

  const Logged log_;
  tests::TemporaryFolder folder_;
  StandingClock clock_;
  serving::Serving behind_;
  ServePlan plan_ = serving::Serving::plan();
  std::unique_ptr<TlsFront> front_;
  std::thread thread_;
  std::list<Slow> clients_;
};

TEST_F(Front, a_handshake_has_five_seconds_though_nothing_else_happens) {
  ASSERT_TRUE(is_taken(host_a));
  clock_.pass(5 * ns_per_s - 1);
  look();
  EXPECT_TRUE(clients_.back().hears_nothing());
  clock_.pass(1);
  EXPECT_TRUE(clients_.back().is_ended());
}

TEST_F(Front, each_has_its_own_five_seconds) {
  ASSERT_TRUE(is_taken(host_a));
  clock_.pass(ns_per_s);
  ASSERT_TRUE(is_taken(host_a));
  clock_.pass(4 * ns_per_s - 1);
  look();
  clock_.pass(1);
  EXPECT_TRUE(clients_.front().is_ended());
  EXPECT_TRUE(clients_.back().hears_nothing());
}

TEST_F(Front, a_host_has_four_handshakes_at_once_and_all_together_sixteen) {
  for (std::uint32_t host = 0; host < 4; ++host) {
    for (int n = 0; n < 4; ++n) EXPECT_TRUE(is_taken(host_a + host)) << host << " " << n;
    EXPECT_FALSE(is_taken(host_a + host)) << host;
  }
  EXPECT_NE(log_.text().find("client 127.0.0.1 by TLS refused: too many of its handshakes have begun"),
            std::string::npos)
      << log_.text();
  EXPECT_FALSE(is_taken(host_a + 4)) << "the seventeenth";
  clients_.front().reset();
  EXPECT_EQ(clients_.size(), 21U);
  bool is_room = false;
  for (int n = 0; n < 100 && !is_room; ++n) is_room = is_taken(host_a + 4);
  EXPECT_TRUE(is_room) << "when one has gone";
  EXPECT_FALSE(is_taken(host_a + 4)) << "and no more than one";
}

TEST_F(Front, a_stranger_is_said_in_the_log) {
  look();
  EXPECT_NE(log_.text().find("warning client 127.1.0.1 is not in serve.allow\n"), std::string::npos) << log_.text();
}

TEST_F(Front, what_speaks_no_tls_is_ended_at_once_and_said) {
  Client plain(front_->port());
  plain.send(std::string("\x00\x01\x00\x00\x00\x06\x01\x04\x00\x00\x00\x02", 12));
  EXPECT_TRUE(plain.is_ended());
  EXPECT_NE(log_.text().find("client 127.0.0.1 by TLS refused: "), std::string::npos) << log_.text();
}

TEST_F(Front, a_file_that_is_not_there_is_named) {
  ServePlan plan = plan_;
  plan.tls->clients_ca = folder_.file("none.pem");
  try {
    const TlsFront front(plan, clock_, behind_.server);
    ADD_FAILURE() << "it was taken";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("serve.tls.clients_ca"), std::string::npos) << error.what();
  }
}

}  // namespace serve_tls_front_test
}  // namespace spindle_twin::firmware

#include "firmware/serve/listen.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cstdint>
#include <string>

#include "firmware/serve/descriptor.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace serve_listen_test {

int option_of(const Descriptor& socket, int level, int option) {
  int value = -1;
  socklen_t size = sizeof value;
  EXPECT_EQ(getsockopt(socket.get(), level, option, &value, &size), 0);
  return value;
}

/// After ten seconds of silence it is asked three times, five seconds apart.
TEST(Listen, who_is_gone_is_noticed_after_25_seconds_and_answers_are_sent_at_once) {
  const Descriptor socket(::socket(AF_INET, SOCK_STREAM, 0));
  make_quick(socket.get());
  EXPECT_NE(option_of(socket, IPPROTO_TCP, TCP_NODELAY), 0);
  EXPECT_NE(option_of(socket, SOL_SOCKET, SO_KEEPALIVE), 0);
  EXPECT_EQ(option_of(socket, IPPROTO_TCP, TCP_KEEPIDLE), 10);
  EXPECT_EQ(option_of(socket, IPPROTO_TCP, TCP_KEEPINTVL), 5);
  EXPECT_EQ(option_of(socket, IPPROTO_TCP, TCP_KEEPCNT), 3);
}

TEST(Listen, where_nobody_may_listen_field_address_and_port_are_named) {
  EXPECT_EQ(tests::refusal_of([] { listen_on("192.0.2.1", 5020, "serve.tls"); }),
            "serve.tls: cannot listen on 192.0.2.1 port 5020: Cannot assign requested address");
}

TEST(Listen, a_port_is_free_again_at_once_when_its_listener_is_gone) {
  int port = 0;
  {
    const Descriptor first(listen_on("127.0.0.1", 0));
    port = port_of(first.get());
    EXPECT_NE(port, 0);
    const Descriptor client(::socket(AF_INET, SOCK_STREAM, 0));
    sockaddr_in there{};
    there.sin_family = AF_INET;
    there.sin_port = htons(static_cast<std::uint16_t>(port));
    there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(::connect(client.get(), reinterpret_cast<const sockaddr*>(&there), sizeof there), 0);
    const Descriptor accepted(::accept(first.get(), nullptr, nullptr));
    EXPECT_GE(accepted.get(), 0);
  }
  const Descriptor again(listen_on("127.0.0.1", port));
  EXPECT_EQ(port_of(again.get()), port);
}

}  // namespace serve_listen_test
}  // namespace spindle_twin::firmware

#include "firmware/serve/acceptor.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "firmware/serve/listen.hpp"
#include "tests/firmware/support/logged.hpp"

namespace spindle_twin::firmware {
namespace serve_acceptor_test {

struct Door {
  explicit Door(const char* allowed)
      : acceptor(Descriptor(listen_on("127.0.0.1", 0)), {*parse_address_range(allowed)}, clock, "http", "http.allow") {}

  /// A client that has connected: its end.
  Descriptor connected() const {
    Descriptor end(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(acceptor.port()));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(end.get(), reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    pollfd waiting = acceptor.polled();
    EXPECT_EQ(poll(&waiting, 1, 10000), 1);
    return end;
  }

  mutable MonotonicClock clock;
  mutable Acceptor acceptor;
};

TEST(Acceptor, lets_in_whom_its_list_allows_one_after_the_other) {
  const Door door("127.0.0.0/8");
  EXPECT_FALSE(door.acceptor.next());
  const Descriptor one = door.connected(), other = door.connected();
  for (int n = 0; n < 2; ++n) {
    const auto client = door.acceptor.next();
    ASSERT_TRUE(client);
    EXPECT_EQ(client->host, INADDR_LOOPBACK);
  }
  EXPECT_FALSE(door.acceptor.next());
  EXPECT_EQ(door.acceptor.rests_until_ns(), 0);
}

TEST(Acceptor, names_the_key_of_the_list_that_a_stranger_is_not_in) {
  const Logged log;
  const Door door("127.0.0.2");
  const Descriptor stranger = door.connected();
  EXPECT_FALSE(door.acceptor.next());
  EXPECT_EQ(log.text(), "warning client 127.0.0.1 is not in http.allow\n");
}

TEST(Acceptor, keeps_the_last_eight_descriptors_for_files_whomever_it_serves) {
  const Door door("127.0.0.0/8");
  const Logged log;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  for (const int left : {8, 9}) {
    const Descriptor client = door.connected();
    const int lowest = ::dup(0);
    ::close(lowest);
    const rlimit little{static_cast<rlim_t>(lowest + left), before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &little), 0);
    const bool came_in = door.acceptor.next().has_value();
    setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_EQ(came_in, left == 9) << left;
  }
  EXPECT_EQ(log.text(),
            "warning http: client 127.0.0.1 refused: the last file descriptors are kept for orders and checkpoint\n");
}

}  // namespace serve_acceptor_test
}  // namespace spindle_twin::firmware

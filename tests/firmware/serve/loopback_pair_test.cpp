#include "firmware/serve/loopback_pair.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>

namespace spindle_twin::firmware {
namespace serve_loopback_pair_test {

TEST(LoopbackPair, what_one_end_sends_the_other_reads_and_neither_waits) {
  const auto pair = loopback_pair();
  ASSERT_TRUE(pair);
  std::array<char, 8> got{};
  EXPECT_EQ(recv(pair->second.get(), got.data(), got.size(), 0), -1);
  EXPECT_EQ(errno, EAGAIN);
  EXPECT_EQ(recv(pair->first.get(), got.data(), got.size(), 0), -1);
  EXPECT_EQ(errno, EAGAIN);
  for (const auto& [from, to] :
       {std::pair(pair->first.get(), pair->second.get()), std::pair(pair->second.get(), pair->first.get())}) {
    ASSERT_EQ(send(from, "twin", 4, 0), 4);
    ASSERT_EQ(recv(to, got.data(), got.size(), 0), 4);
    EXPECT_EQ(std::string(got.data(), 4), "twin");
  }
}

TEST(LoopbackPair, the_end_of_one_is_seen_at_the_other) {
  auto pair = loopback_pair();
  ASSERT_TRUE(pair);
  pair->first = Descriptor();
  char byte = 0;
  EXPECT_EQ(recv(pair->second.get(), &byte, 1, 0), 0);
}

TEST(LoopbackPair, without_descriptors_there_is_none) {
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  const int next = ::dup(0);
  ::close(next);
  for (const int left : {0, 1, 2}) {
    const rlimit few{static_cast<rlim_t>(next + left), before.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &few);
    EXPECT_FALSE(loopback_pair()) << left;
    EXPECT_EQ(errno, EMFILE) << left;
  }
  ::setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_TRUE(loopback_pair()) << "nothing was left open";
}

}  // namespace serve_loopback_pair_test
}  // namespace spindle_twin::firmware

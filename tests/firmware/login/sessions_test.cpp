#include "firmware/login/sessions.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {
namespace login_sessions_test {

constexpr std::int64_t minute_ns = 60 * ns_per_s;

TEST(Sessions, end_when_nothing_was_commanded_for_so_long) {
  Sessions sessions(15 * 60.0, 8 * 3600.0);
  const std::string token = sessions.begin("anna", 0);
  EXPECT_EQ(sessions.user_of(token, 14 * minute_ns, true), "anna");
  EXPECT_EQ(sessions.user_of(token, 28 * minute_ns, false), "anna");  // looking on does not count
  EXPECT_EQ(sessions.user_of(token, 29 * minute_ns, true), std::nullopt);
  EXPECT_EQ(sessions.user_of(token, 0, true), std::nullopt) << "ended for ever";
}

TEST(Sessions, end_after_the_longest_time_however_busy) {
  Sessions sessions(15 * 60.0, 8 * 3600.0);
  const std::string token = sessions.begin("anna", 0);
  std::int64_t now_ns = 0;
  while (sessions.user_of(token, now_ns, true)) now_ns += 10 * minute_ns;
  EXPECT_EQ(now_ns, 8 * 60 * minute_ns);
}

TEST(Sessions, end_when_they_are_ended_and_no_other_one_with_them) {
  Sessions sessions(900.0, 900.0);
  const std::string one = sessions.begin("anna", 0), other = sessions.begin("anna", 0);
  sessions.end(one);
  EXPECT_EQ(sessions.user_of(one, 1, true), std::nullopt);
  EXPECT_EQ(sessions.user_of(other, 1, true), "anna");
  for (const std::string& guess : {std::string(), other.substr(1), other + "0", std::string(64, '0')}) {
    EXPECT_EQ(sessions.user_of(guess, 1, true), std::nullopt) << guess;
  }
}

TEST(Sessions, are_sixteen_at_most_and_the_longest_idle_one_makes_room) {
  Sessions sessions(900.0, 900.0);
  std::set<std::string> tokens;
  const std::string first = sessions.begin("first", 0), second = sessions.begin("second", 1);
  for (int n = 2; n < 16; ++n) tokens.insert(sessions.begin("more", n));
  EXPECT_EQ(sessions.user_of(first, 100, true), "first");
  tokens.insert(sessions.begin("late", 101));
  EXPECT_EQ(tokens.size(), 15U);
  for (const std::string& token : tokens) {
    EXPECT_EQ(token.size(), 64U);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos) << token;
  }
  EXPECT_EQ(sessions.user_of(second, 102, true), std::nullopt);
  EXPECT_EQ(sessions.user_of(first, 102, true), "first");
}

}  // namespace login_sessions_test
}  // namespace spindle_twin::firmware

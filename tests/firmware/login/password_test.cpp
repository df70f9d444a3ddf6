#include "firmware/login/password.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <termios.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace spindle_twin::firmware {
namespace login_password_test {

TEST(Password, is_known_by_its_hash_and_no_other_one_is) {
  const std::string hash = hash_password("correct horse");
  EXPECT_TRUE(hash.starts_with("$argon2id$v=19$m=19456,t=2,p=1$")) << hash;
  EXPECT_EQ(wrong_with_hash(hash), "");
  EXPECT_TRUE(is_password(hash, "correct horse"));
  EXPECT_FALSE(is_password(hash, "correct horse "));
  EXPECT_FALSE(is_password(hash, ""));
  EXPECT_NE(hash_password("correct horse"), hash) << "the same salt twice";
}

TEST(Password, hashes_of_other_forms_and_those_that_take_the_machine_are_refused) {
  const std::string salt = "$c2FsdHNhbHRzYWx0c2FsdA", sum = "$" + std::string(43, 'A');
  EXPECT_EQ(wrong_with_hash("$argon2id$v=19$m=65536,t=10,p=1" + salt + sum), "");
  for (const std::string& other :
       {std::string(), std::string("secret"), "$2y$10$" + std::string(53, 'a'),
        "$argon2i$v=19$m=19456,t=2,p=1" + salt + sum, "$argon2id$v=16$m=19456,t=2,p=1" + salt + sum,
        "$argon2id$v=19$m=19456,t=2,p=1" + salt, "$argon2id$v=19$m=19456,t=2,p=1" + salt + sum + "A"}) {
    EXPECT_NE(wrong_with_hash(other).find("must be a hash of argon2id"), std::string::npos) << other;
  }
  for (const char* much : {"m=65537,t=2", "m=8,t=11", "m=999999999,t=1"}) {
    const std::string hash = std::string("$argon2id$v=19$") + much + ",p=1" + salt + sum;
    EXPECT_NE(wrong_with_hash(hash).find("at most m=65536 (KiB) and t=10"), std::string::npos) << hash;
  }
}

/// What ask_for_password() takes of these lines, or says to them.
std::string asked_lines(const std::string& lines) {
  std::istringstream typed(lines);
  std::streambuf* const before = std::cin.rdbuf(typed.rdbuf());
  std::cin.clear();
  std::string said;
  try {
    said = ask_for_password();
  } catch (const std::runtime_error& error) {
    said = error.what();
  }
  std::cin.rdbuf(before);
  std::cin.clear();
  return said;
}
/// By a person who types this; on a terminal it asks twice.
std::string asked(const std::string& password) {
  const std::string said = asked_lines(password + "\n" + password + "\n");
  return said == password ? "taken" : said;
}

/// Another standard input while it lives; what is typed comes from asked() all the same.
class StandardInput {
 public:
  explicit StandardInput(const char* path) {
    const int other = ::open(path, O_RDWR | O_NOCTTY);
    EXPECT_GE(other, 0) << path;
    ::dup2(other, STDIN_FILENO);
    ::close(other);
  }
  ~StandardInput() {
    ::dup2(before_, STDIN_FILENO);
    ::close(before_);
  }
  StandardInput(const StandardInput&) = delete;
  StandardInput& operator=(const StandardInput&) = delete;

 private:
  int before_ = ::dup(STDIN_FILENO);
};

TEST(Password, is_asked_for_twice_at_a_terminal_and_once_elsewhere) {
  {
    const StandardInput file("/dev/null");
    EXPECT_EQ(asked_lines("password 1\n"), "password 1");
    EXPECT_EQ(asked_lines("password 1\r\npassword 2\n"), "password 1");
    EXPECT_EQ(asked_lines(""), "no password was given");
  }
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0 || ::grantpt(terminal) != 0 || ::unlockpt(terminal) != 0) GTEST_SKIP() << "no terminal here";
  {
    const StandardInput keyboard(::ptsname(terminal));
    EXPECT_EQ(asked_lines("password 1\npassword 1\n"), "password 1");
    EXPECT_EQ(asked_lines("password 1\npassword 2\n"), "these are two passwords");
    EXPECT_EQ(asked_lines("password 1\n"), "no password was given");
    termios shows{};
    ASSERT_EQ(::tcgetattr(STDIN_FILENO, &shows), 0);
    EXPECT_NE(shows.c_lflag & static_cast<tcflag_t>(ECHO), 0U) << "what is typed is seen again";
  }
  ::close(terminal);
}

TEST(Password, has_8_to_128_bytes) {
  for (const std::size_t bytes : {8U, 9U, 127U, 128U}) EXPECT_EQ(asked(std::string(bytes, 'x')), "taken") << bytes;
  for (const std::size_t bytes : {0U, 7U, 129U}) {
    EXPECT_EQ(asked(std::string(bytes, 'x')), "a password must have 8 to 128 bytes") << bytes;
  }
}

TEST(Password, is_of_a_user_whose_name_has_up_to_32_letters_digits_and_three_other_characters) {
  for (const std::string& name : {std::string("a"), std::string("Anna-2.b_c"), std::string(32, 'n')}) {
    EXPECT_TRUE(is_user_name(name)) << name;
  }
  for (const std::string& name : {std::string(), std::string(33, 'n'), std::string("a b"), std::string("a:b")}) {
    EXPECT_FALSE(is_user_name(name)) << name;
  }
}

}  // namespace login_password_test
}  // namespace spindle_twin::firmware

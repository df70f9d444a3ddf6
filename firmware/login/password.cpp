#include "firmware/login/password.hpp"

#include <sodium.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <iostream>
#include <regex>
#include <stdexcept>

namespace spindle_twin::firmware {
namespace {

// OWASP's password storage cheat sheet: argon2id with 19 MiB and two passes.
constexpr unsigned long long passes = 2;
constexpr std::size_t memory_bytes = std::size_t{19456} * 1024;
constexpr int most_KiB = 65536;
constexpr int most_passes = 10;

/// The terminal shows nothing of what is typed for as long as this lives.
class Unseen {
 public:
  Unseen() {
    tcgetattr(STDIN_FILENO, &before_);
    termios now = before_;
    now.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    tcsetattr(STDIN_FILENO, TCSAFLUSH, &now);
  }
  ~Unseen() { tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_); }
  Unseen(const Unseen&) = delete;
  Unseen& operator=(const Unseen&) = delete;

 private:
  termios before_{};
};

std::string read_line() {
  std::string line;
  if (!std::getline(std::cin, line)) throw std::runtime_error("no password was given");
  if (line.ends_with('\r')) line.pop_back();
  return line;
}

std::string typed(const char* prompt) {
  const Unseen unseen;
  std::fputs(prompt, stderr);
  std::string line = read_line();
  std::fputs("\n", stderr);
  return line;
}

}  // namespace

std::string hash_password(const std::string& password) {
  if (sodium_init() < 0) throw std::runtime_error("libsodium has no source of random numbers");
  std::array<char, crypto_pwhash_argon2id_STRBYTES> hash{};
  if (crypto_pwhash_argon2id_str(hash.data(), password.data(), password.size(), passes, memory_bytes) != 0) {
    throw std::runtime_error("there is no memory to hash a password");
  }
  return hash.data();
}

bool is_password(const std::string& hash, const std::string& password) {
  return sodium_init() >= 0 && crypto_pwhash_argon2id_str_verify(hash.c_str(), password.data(), password.size()) == 0;
}

std::string wrong_with_hash(const std::string& hash) {
  static const std::regex form(
      R"(\$argon2id\$v=19\$m=(\d{1,9}),t=(\d{1,9}),p=1\$[A-Za-z0-9+/]{22}\$[A-Za-z0-9+/]{43})");
  std::smatch found;
  if (!std::regex_match(hash, found, form)) {
    return "must be a hash of argon2id as `spindle-twind --hash-password NAME` prints it";
  }
  if (std::stoi(found[1]) > most_KiB || std::stoi(found[2]) > most_passes) {
    return "takes too much of the machine: at most m=65536 (KiB) and t=10 are allowed";
  }
  return {};
}

bool is_user_name(const std::string& name) {
  constexpr std::size_t longest = 32;
  return !name.empty() && name.size() <= longest && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  });
}

std::string ask_for_password() {
  const bool is_terminal = isatty(STDIN_FILENO) == 1;
  std::string password = is_terminal ? typed("password: ") : read_line();
  if (password.size() < shortest_password || password.size() > longest_password) {
    throw std::runtime_error("a password must have 8 to 128 bytes");
  }
  if (is_terminal && typed("once more: ") != password) throw std::runtime_error("these are two passwords");
  return password;
}

}  // namespace spindle_twin::firmware

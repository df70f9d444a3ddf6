#include "firmware/login/accounts.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "firmware/login/password.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {
namespace {

void check_mode(const std::string& path) {
  struct stat found {};
  if (stat(path.c_str(), &found) != 0) throw rom::InputError({path, 0}, "", std::strerror(errno));
  if (!S_ISREG(found.st_mode)) throw rom::InputError({path, 0}, "", "must be a file");
  if ((found.st_mode & (S_IRWXO | S_IWGRP)) != 0) {
    throw rom::InputError({path, 0}, "", "must be for its owner, and for its group to read: chmod 640");
  }
}

}  // namespace

std::vector<Account> read_accounts(const std::string& path) {
  check_mode(path);
  std::ifstream file(path);
  if (!file) throw rom::InputError({path, 0}, "", "cannot be read");
  std::vector<Account> accounts;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    const rom::SourceLine where{path, ++number};
    if (line.empty() || line.starts_with('#')) continue;
    const std::size_t colon = line.find(':');
    Account account{line.substr(0, colon), colon == std::string::npos ? "" : line.substr(colon + 1)};
    if (colon == std::string::npos || !is_user_name(account.user)) {
      throw rom::InputError(where, "", "must be NAME:HASH, the name of 1 to 32 letters, digits, '_', '-' or '.'");
    }
    const std::string wrong = wrong_with_hash(account.hash);
    if (!wrong.empty()) throw rom::InputError(where, "the hash of " + account.user, wrong);
    const bool is_known =
        std::any_of(accounts.begin(), accounts.end(), [&](const Account& each) { return each.user == account.user; });
    if (is_known) throw rom::InputError(where, account.user, "stands in a line before already");
    accounts.push_back(std::move(account));
  }
  if (accounts.empty()) throw rom::InputError({path, 0}, "", "has no line NAME:HASH: nobody could log in");
  return accounts;
}

}  // namespace spindle_twin::firmware

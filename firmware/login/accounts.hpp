#pragma once

#include <string>
#include <vector>

namespace spindle_twin::firmware {

/// Who may log in.
struct Account {
  std::string user;
  std::string hash;  ///< of the password

  bool operator==(const Account&) const = default;
};

/// Reads a file of lines NAME:HASH as `spindle-twind --hash-password NAME` prints them; empty lines and those that
/// begin with '#' are left out. Throws rom::InputError with file, line and what is allowed: for what cannot be read,
/// for a name of other characters or that stands there twice, for a hash of another form, for a file without a line
/// and for one that others than its owner and group may read or write.
std::vector<Account> read_accounts(const std::string& path);

}  // namespace spindle_twin::firmware

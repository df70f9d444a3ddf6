#pragma once

#include <string>

/// Passwords are kept as hashes of argon2id (RFC 9106, libsodium), which cost memory and time to try: 19 MiB and some
/// ten milliseconds each. Nothing here may run in the cycle.
namespace spindle_twin::firmware {

inline constexpr std::size_t shortest_password = 8;
inline constexpr std::size_t longest_password = 128;  ///< bytes

/// "$argon2id$v=19$m=19456,t=2,p=1$...", another one each time. Throws std::runtime_error where there is no memory.
std::string hash_password(const std::string& password);

/// Takes as long whether it is the one or not.
bool is_password(const std::string& hash, const std::string& password);

/// Why this is no hash that the daemon takes: one of argon2id, whole, of at most 64 MiB and 10 passes, so that a login
/// does not take the machine's memory. Empty: it is one.
std::string wrong_with_hash(const std::string& hash);

/// Whether all characters are letters, digits, '_', '-' or '.', 1 to 32 of them.
bool is_user_name(const std::string& name);

/// A password from the terminal, twice and without showing it, or the first line of stdin where that is none. Throws
/// std::runtime_error saying what is wrong with it.
std::string ask_for_password();

}  // namespace spindle_twin::firmware

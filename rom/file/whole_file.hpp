#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace spindle_twin::rom {

/// Behind a path and in front of six letters or digits of chance: the name that a file has until it is whole. Only a
/// process that was killed leaves one behind.
inline constexpr std::string_view unfinished_mark = ".unfinished-";

/// Replaces `path` by `bytes` so that a reader sees the old file or the new one, never a part, also over a power cut:
/// temporary file in the same folder, write, fsync, rename, fsync of the folder. Throws InputError with the system's
/// reason; then `path` is as it was. Permissions 0644 less the umask. A path that is a device or a folder is refused.
void write_whole_file(const std::string& path, std::span<const std::uint8_t> bytes);
void write_whole_file(const std::string& path, const std::string& text);

/// Throws InputError, naming `field` and the system's reason, if `path` cannot become a file: before minutes of work,
/// not after them. Leaves nothing behind.
void check_writable(const std::string& path, const std::string& field);

/// A new folder beside the wanted one, to be filled and then renamed to it. Throws InputError naming `field`.
std::string make_folder_beside(const std::string& path, const std::string& field);

/// A new file, mode 0600 from its first byte on, whole or not at all. Throws InputError if `path` exists already.
void write_private_file(const std::string& path, const std::string& text);

/// Throws InputError if the file cannot be read or is longer than `largest_bytes`.
std::vector<std::uint8_t> read_whole_file(const std::string& path, std::uint64_t largest_bytes);

}  // namespace spindle_twin::rom

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace arbox::io {

/// The whole content of a regular file. Throws IoError that names the path for a missing or
/// unreadable file and for a directory. Reads up to `limit` bytes where one is given.
std::string read_file(const std::filesystem::path& path, std::uint64_t limit = UINT64_MAX);

/// Writes beside `path` and renames, so that a reader sees the old or the new content, never a
/// part; a pipe or a device such as /dev/stdout is written to as it is, a
/// link stays and what it leads to is written. The parent folder must
/// exist. Throws IoError with the reason.
void write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace arbox::io

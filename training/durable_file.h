#pragma once

#include <filesystem>
#include <string_view>

namespace arbox::training {

/// Writes beside `path`, waits until the bytes are on the disk, and renames: after a crash of
/// program or machine at any moment there is the old file or the new one, whole. Throws IoError.
void write_durably(const std::filesystem::path& path, std::string_view content);

/// Removes what write_durably left in a folder when it was killed.
void remove_unfinished(const std::filesystem::path& folder);

}  // namespace arbox::training

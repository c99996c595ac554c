#pragma once

#include <filesystem>
#include <string>

namespace arbox::cli {

/// Throws UsageError that names the flag unless pictures can be written under that name; asked
/// before the work begins.
void require_picture(const std::string& flag, const std::filesystem::path& path);

}  // namespace arbox::cli

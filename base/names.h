#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace arbox {

/// The name of `known` with the fewest edits (Levenshtein) from `name`, the first of equals; empty
/// if `known` is empty or the nearest differs in more than half of its letters.
std::string nearest_name(std::string_view name, const std::vector<std::string>& known);

/// "unknown WHAT 'NAME', nearest is 'X'; known: A, X" for error messages.
std::string unknown_name_text(std::string_view what, std::string_view name,
                              const std::vector<std::string>& known);

/// The parts with `separator` between them.
std::string join(const std::vector<std::string>& parts, std::string_view separator);

}  // namespace arbox

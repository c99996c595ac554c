#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "arbox/io/internal/text.h"
#include "arbox/io/number_type.h"

namespace arbox::io::internal {

/// One number of a record and where its bytes go.
struct RecordElement {
  std::string name;
  NumberType type = NumberType::kFloat32;
  std::size_t offset = 0;
};

/// Stores a token as a number of the element's type; refuses anything else.
void store_token(std::string_view token, const RecordElement& element, std::byte* record,
                 const TextPlace& place);

/// Stores a line of exactly one blank-separated number an element.
void store_line(std::string_view line, std::span<const RecordElement> elements, std::byte* record,
                const TextPlace& place);

}  // namespace arbox::io::internal

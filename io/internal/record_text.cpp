#include "arbox/io/internal/record_text.h"

#include <cstring>
#include <type_traits>

#include "arbox/io/internal/load_number.h"
#include "arbox/io/internal/parse.h"

namespace arbox::io::internal {
namespace {

bool store(std::string_view token, NumberType type, std::byte* to) {
  return with_type(type, [&](auto number) {
    if constexpr (std::is_arithmetic_v<decltype(number)>) {
      if (!to_number(token, number)) return false;
      std::memcpy(to, &number, sizeof number);
      return true;
    } else {
      return false;
    }
  });
}

}  // namespace

void store_token(std::string_view token, const RecordElement& element, std::byte* record,
                 const TextPlace& place) {
  if (store(token, element.type, record + element.offset)) return;
  refuse(place, "a " + std::string(name_of(element.type)) + " as " + element.name,
         quoted_text(token));
}

void store_line(std::string_view line, std::span<const RecordElement> elements, std::byte* record,
                const TextPlace& place) {
  const char* at = line.data();
  const char* const end = at + line.size();
  std::size_t count = 0;
  for (;;) {
    while (at < end && is_blank(*at)) ++at;
    if (at == end) break;
    const char* const begin = at;
    while (at < end && !is_blank(*at)) ++at;
    if (count < elements.size()) {
      store_token({begin, static_cast<std::size_t>(at - begin)}, elements[count], record, place);
    }
    ++count;
  }
  if (count != elements.size()) {
    refuse(place, std::to_string(elements.size()) + " numbers", std::to_string(count));
  }
}

}  // namespace arbox::io::internal

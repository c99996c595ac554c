#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/io/internal/columns.h"
#include "arbox/io/internal/load_number.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/text.h"

namespace arbox::io::internal {

std::size_t columns_asked(const ReadOptions& options) {
  std::size_t count = 0;
  if (options.channels.size() != 1 || !to_number(options.channels[0], count)) {
    return options.channels.size();
  }
  if (count < 3 || count > kMostColumns) {
    throw InvalidArgument("channels: expected 3 to " + std::to_string(kMostColumns) +
                          " columns, got " + std::to_string(count));
  }
  return count;
}

void require_no_channels(const std::string& name, const ReadOptions& options) {
  if (options.channels.empty()) return;
  throw InvalidArgument(name +
                        ": the option channels is for files that do not name their columns; " +
                        "this one does");
}

std::vector<std::string> column_names(std::size_t count, bool negative_tail,
                                      const std::string& name, const ReadOptions& options) {
  const std::size_t asked = columns_asked(options);
  if (asked > 0 && asked != count) {
    fail(name, "expected the " + std::to_string(asked) + " columns of the option channels, got " +
                   std::to_string(count));
  }
  if (options.channels.size() > 1) return options.channels;
  if (count < 3) {
    fail(name, "expected at least 3 columns (x, y, z), got " + std::to_string(count));
  }
  std::vector<std::string> names{"x", "y", "z"};
  const auto add = [&](std::initializer_list<const char*> more) {
    names.insert(names.end(), more.begin(), more.end());
  };
  if (count == 4 || count == 5 || count == 7) add({"intensity"});
  if (count == 5) add({"ring"});
  if (count == 6 && negative_tail) {
    add({"normal_x", "normal_y", "normal_z"});
  } else if (count == 6 || count == 7) {
    add({"r", "g", "b"});
  }
  while (names.size() < count) names.push_back("column_" + std::to_string(names.size()));
  return names;
}

bool has_negative_tail(const std::vector<Column>& columns, std::size_t rows) {
  if (columns.size() != 6) return false;
  return std::any_of(columns.begin() + 3, columns.end(), [&](const Column& column) {
    return with_type(column.type, [&](auto number) {
      using Number = decltype(number);
      for (std::size_t i = 0; i < rows; ++i) {
        if (static_cast<double>(
                load_number<Number>(column.data + i * column.stride, column.big_endian)) < 0.0) {
          return true;
        }
      }
      return false;
    });
  });
}

}  // namespace arbox::io::internal

#include "arbox/io/internal/box_columns.h"

#include <algorithm>

namespace arbox::io::internal {
namespace {

constexpr std::string_view kExpectedHeader =
    "a header of x y z l w h with yaw or qw qx qy qz, and optionally object, score, class";

bool has(const BoxColumns& layout, std::string_view name) {
  return std::find(layout.begin(), layout.end(), name) != layout.end();
}

std::size_t find_outside_quotes(std::string_view line, char wanted, std::size_t from = 0) {
  bool inside = false;
  for (std::size_t i = from; i < line.size(); ++i) {
    if (line[i] == '"') inside = !inside;
    if (line[i] == wanted && !inside) return i;
  }
  return std::string_view::npos;
}

bool is_known(std::string_view name) {
  const auto among = [name](const auto& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return among(kBoxColumns) || among(kQuaternionColumns) || name == "yaw" || name == "object" ||
         name == "score" || name == "class";
}

std::vector<BoxColumns> headerless_choices(const BoxTableOptions& options) {
  std::vector<BoxColumns> tails = {{}};
  if (options.score) tails.push_back({"score"});
  if (options.class_name) tails.push_back({"class"});
  if (options.score && options.class_name) {
    tails.push_back({"score", "class"});
    tails.push_back({"class", "score"});
  }
  std::vector<BoxColumns> layouts;
  for (const bool object : {false, true}) {
    if (object && !options.object) continue;
    for (const bool quaternion : {false, true}) {
      BoxColumns box(kBoxColumns.begin(), kBoxColumns.end());
      if (object) box.insert(box.begin(), "object");
      if (quaternion) {
        box.insert(box.end(), kQuaternionColumns.begin(), kQuaternionColumns.end());
      } else {
        box.emplace_back("yaw");
      }
      for (const BoxColumns& tail : tails) {
        layouts.push_back(box);
        layouts.back().insert(layouts.back().end(), tail.begin(), tail.end());
      }
    }
  }
  return layouts;
}

bool fits(const BoxColumns& layout, const std::vector<std::string_view>& fields) {
  if (layout.size() != fields.size()) return false;
  const auto name = std::find(layout.begin(), layout.end(), "class");
  return name == layout.end() || !is_number(fields[name - layout.begin()]);
}

}  // namespace

std::vector<std::string_view> split_fields(std::string_view line) {
  const char separator = find_outside_quotes(line, ',') != std::string_view::npos   ? ','
                         : find_outside_quotes(line, ';') != std::string_view::npos ? ';'
                                                                                    : '\0';
  if (separator == '\0') return split_white_space(line);
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(find_outside_quotes(line, separator, begin), line.size());
    fields.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return fields;
}

std::string unquoted(std::string_view field) {
  if (field.size() < 2 || field.front() != '"' || field.back() != '"') return std::string(field);
  std::string result;
  for (std::size_t i = 1; i + 1 < field.size(); ++i) {
    result += field[i];
    if (field[i] == '"' && field[i + 1] == '"') ++i;
  }
  return result;
}

bool is_header(const std::vector<std::string_view>& fields) {
  return std::none_of(fields.begin(), fields.end(), is_number);
}

BoxColumns header_columns(const std::vector<std::string_view>& fields, const TextPlace& place) {
  BoxColumns layout;
  for (const auto field : fields) {
    if (!is_known(field))
      refuse(place, std::string(kExpectedHeader), "the name " + quoted_text(field));
    if (has(layout, field)) refuse(place, "each column once", quoted_text(field) + " twice");
    layout.push_back(field);
  }
  const auto require = [&](std::string_view name) {
    if (!has(layout, name)) {
      refuse(place, std::string(kExpectedHeader), "no column " + quoted_text(name));
    }
  };
  std::for_each(kBoxColumns.begin(), kBoxColumns.end(), require);
  const bool any_quaternion = std::any_of(kQuaternionColumns.begin(), kQuaternionColumns.end(),
                                          [&](std::string_view name) { return has(layout, name); });
  if (!any_quaternion) {
    require("yaw");
  } else {
    std::for_each(kQuaternionColumns.begin(), kQuaternionColumns.end(), require);
    if (has(layout, "yaw")) refuse(place, "yaw or a quaternion", "both");
  }
  return layout;
}

BoxColumns guessed_columns(const std::vector<std::string_view>& fields,
                           const BoxTableOptions& options, const TextPlace& place) {
  const auto layouts = headerless_choices(options);
  const BoxColumns* found = nullptr;
  for (const BoxColumns& layout : layouts) {
    if (!fits(layout, fields)) continue;
    if (found != nullptr) {
      refuse(place, "a header line that names the columns",
             std::to_string(fields.size()) + " fields that could be '" + joined(*found, " ") +
                 "' or '" + joined(layout, " ") + "'");
    }
    found = &layout;
  }
  if (found != nullptr) return *found;
  std::string choices;
  for (const BoxColumns& layout : layouts) {
    choices.append(choices.empty() ? "'" : " or '").append(joined(layout, " ")).append("'");
  }
  refuse(place, choices, std::to_string(fields.size()) + " fields");
}

}  // namespace arbox::io::internal

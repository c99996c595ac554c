#include "arbox/io/box_table.h"

#include <algorithm>
#include <array>
#include <optional>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/rotation.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

using geometry::Box;
using internal::LineReader;
using internal::parse_number;
using internal::quoted_text;
using internal::refuse;
using internal::TextPlace;

using Layout = std::vector<std::string_view>;

constexpr std::array<std::string_view, 6> kBoxColumns = {"x", "y", "z", "l", "w", "h"};
constexpr std::array<std::string_view, 4> kQuaternionColumns = {"qw", "qx", "qy", "qz"};
constexpr std::string_view kExpectedHeader =
    "a header of x y z l w h with yaw or qw qx qy qz, and optionally object, score, class";

bool has(const Layout& layout, std::string_view name) {
  return std::find(layout.begin(), layout.end(), name) != layout.end();
}

std::string joined(const Layout& layout) {
  std::string text;
  for (const auto name : layout) text.append(text.empty() ? "" : " ").append(name);
  return text;
}

std::size_t find_outside_quotes(std::string_view line, char wanted, std::size_t from = 0) {
  bool inside = false;
  for (std::size_t i = from; i < line.size(); ++i) {
    if (line[i] == '"') inside = !inside;
    if (line[i] == wanted && !inside) return i;
  }
  return std::string_view::npos;
}

std::vector<std::string_view> split_fields(std::string_view line) {
  const char separator = find_outside_quotes(line, ',') != std::string_view::npos   ? ','
                         : find_outside_quotes(line, ';') != std::string_view::npos ? ';'
                                                                                    : '\0';
  if (separator == '\0') return internal::split_white_space(line);
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(find_outside_quotes(line, separator, begin), line.size());
    fields.push_back(internal::trimmed(line.substr(begin, end - begin)));
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

bool is_known(std::string_view name) {
  const auto among = [name](const auto& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return among(kBoxColumns) || among(kQuaternionColumns) || name == "yaw" || name == "object" ||
         name == "score" || name == "class";
}

Layout header_layout(const std::vector<std::string_view>& fields, const TextPlace& place) {
  Layout layout;
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

std::vector<Layout> headerless_layouts(const BoxTableOptions& options) {
  std::vector<Layout> tails = {{}};
  if (options.score) tails.push_back({"score"});
  if (options.class_name) tails.push_back({"class"});
  if (options.score && options.class_name) {
    tails.push_back({"score", "class"});
    tails.push_back({"class", "score"});
  }
  std::vector<Layout> layouts;
  for (const bool object : {false, true}) {
    if (object && !options.object) continue;
    for (const bool quaternion : {false, true}) {
      Layout box(kBoxColumns.begin(), kBoxColumns.end());
      if (object) box.insert(box.begin(), "object");
      if (quaternion) {
        box.insert(box.end(), kQuaternionColumns.begin(), kQuaternionColumns.end());
      } else {
        box.emplace_back("yaw");
      }
      for (const Layout& tail : tails) {
        layouts.push_back(box);
        layouts.back().insert(layouts.back().end(), tail.begin(), tail.end());
      }
    }
  }
  return layouts;
}

bool fits(const Layout& layout, const std::vector<std::string_view>& fields) {
  if (layout.size() != fields.size()) return false;
  const auto name = std::find(layout.begin(), layout.end(), "class");
  return name == layout.end() || !internal::is_number(fields[name - layout.begin()]);
}

Layout guessed_layout(const std::vector<std::string_view>& fields, const BoxTableOptions& options,
                      const TextPlace& place) {
  const auto layouts = headerless_layouts(options);
  const Layout* found = nullptr;
  for (const Layout& layout : layouts) {
    if (!fits(layout, fields)) continue;
    if (found != nullptr) {
      refuse(place, "a header line that names the columns",
             std::to_string(fields.size()) + " fields that could be '" + joined(*found) + "' or '" +
                 joined(layout) + "'");
    }
    found = &layout;
  }
  if (found != nullptr) return *found;
  std::string choices;
  for (const Layout& layout : layouts) {
    choices.append(choices.empty() ? "'" : " or '").append(joined(layout)).append("'");
  }
  refuse(place, choices, std::to_string(fields.size()) + " fields");
}

class RowReader {
 public:
  explicit RowReader(Layout layout) : layout_(std::move(layout)) {
    for (std::size_t i = 0; i < 6; ++i) box_[i] = *column(kBoxColumns[i]);
    yaw_ = column("yaw");
    if (!yaw_) {
      for (std::size_t i = 0; i < 4; ++i) quaternion_[i] = *column(kQuaternionColumns[i]);
    }
    object_ = column("object");
    score_ = column("score");
    class_ = column("class");
  }

  void read(const std::vector<std::string_view>& fields, const TextPlace& place,
            BoxTable& table) const {
    if (fields.size() != layout_.size()) {
      refuse(place, std::to_string(layout_.size()) + " fields (" + joined(layout_) + ")",
             std::to_string(fields.size()));
    }
    table.boxes.push_back(read_box(fields, place));
    if (object_) {
      table.objects.push_back(internal::parse_integer(fields[*object_], "object", place));
    }
    if (score_) table.scores.push_back(parse_number(fields[*score_], "score", place));
    if (class_) table.classes.push_back(unquoted(fields[*class_]));
  }

 private:
  std::optional<std::size_t> column(std::string_view name) const {
    const auto found = std::find(layout_.begin(), layout_.end(), name);
    if (found == layout_.end()) return std::nullopt;
    return found - layout_.begin();
  }

  Box read_box(const std::vector<std::string_view>& fields, const TextPlace& place) const {
    std::array<double, 6> values;
    for (std::size_t i = 0; i < 6; ++i) {
      values[i] = parse_number(fields[box_[i]], kBoxColumns[i], place);
      if (i >= 3 && values[i] <= 0.0) {
        refuse(place, "a size above zero as " + std::string(kBoxColumns[i]),
               quoted_text(fields[box_[i]]));
      }
    }
    const Eigen::Vector3d center(values[0], values[1], values[2]);
    const Eigen::Vector3d size(values[3], values[4], values[5]);
    if (yaw_)
      return geometry::make_yaw_box(center, size, parse_number(fields[*yaw_], "yaw", place));
    return {.center = center, .size = size, .rotation = read_rotation(fields, place)};
  }

  geometry::Quaternion read_rotation(const std::vector<std::string_view>& fields,
                                     const TextPlace& place) const {
    std::array<double, 4> q;
    for (std::size_t i = 0; i < 4; ++i) {
      q[i] = parse_number(fields[quaternion_[i]], kQuaternionColumns[i], place);
    }
    const geometry::Quaternion rotation(q[0], q[1], q[2], q[3]);
    if (const auto accepted = internal::accepted_rotation(rotation)) return *accepted;
    std::string came = "norm ";
    internal::append_number(came, rotation.norm());
    refuse(place, "a unit quaternion qw qx qy qz (norm 1 within 1e-3)", came);
  }

  Layout layout_;
  std::array<std::size_t, 6> box_{};
  std::array<std::size_t, 4> quaternion_{};
  std::optional<std::size_t> yaw_, object_, score_, class_;
};

bool is_header(const std::vector<std::string_view>& fields) {
  return std::none_of(fields.begin(), fields.end(), internal::is_number);
}

void append_class(std::string& text, const std::string& name) {
  const bool plain = !name.empty() && name.find_first_of(",;\"\t \v\f") == std::string::npos;
  if (name.find_first_of("\r\n") != std::string::npos) {
    throw InvalidArgument("format_box_table: a class name may not hold a line break, got " +
                          quoted_text(name));
  }
  if (plain) {
    text += name;
    return;
  }
  text += '"';
  for (const char letter : name) text.append(letter == '"' ? 2 : 1, letter);
  text += '"';
}

void require_length(std::size_t length, std::size_t boxes, const char* column) {
  if (length != 0 && length != boxes) {
    throw InvalidArgument("format_box_table: column " + std::string(column) + " has " +
                          std::to_string(length) + " entries for " + std::to_string(boxes) +
                          " boxes");
  }
}

void append_header(std::string& text, const BoxTable& table, bool yaw_only) {
  if (!table.objects.empty()) text += "object,";
  text += yaw_only ? "x,y,z,l,w,h,yaw" : "x,y,z,l,w,h,qw,qx,qy,qz";
  if (!table.scores.empty()) text += ",score";
  if (!table.classes.empty()) text += ",class";
  text += '\n';
}

void append_box(std::string& text, const Box& box, bool yaw_only) {
  for (const double value :
       {box.center.x(), box.center.y(), box.center.z(), box.size.x(), box.size.y(), box.size.z()}) {
    internal::append_number(text, value);
    text += ',';
  }
  const auto& q = box.rotation;
  if (yaw_only) {
    internal::append_number(text, geometry::yaw(box));
    return;
  }
  internal::append_number(text, q.w());
  for (const double value : {q.x(), q.y(), q.z()}) {
    text += ',';
    internal::append_number(text, value);
  }
}

}  // namespace

BoxTable parse_box_table(std::string_view text, std::string_view source,
                         const BoxTableOptions& options) {
  BoxTable table;
  LineReader lines(text, source);
  if (!lines.next_filled()) return table;
  std::string_view first = internal::trimmed(lines.line());
  if (first.starts_with('#')) first.remove_prefix(1);
  const auto names = split_fields(first);
  const bool header = is_header(names);
  const RowReader reader(header ? header_layout(names, lines.place())
                                : guessed_layout(names, options, lines.place()));
  if (!header) reader.read(names, lines.place(), table);
  while (lines.next_filled()) reader.read(split_fields(lines.line()), lines.place(), table);
  return table;
}

BoxTable read_box_table(const std::filesystem::path& path, const BoxTableOptions& options) {
  return parse_box_table(read_file(path), path.string(), options);
}

std::string format_box_table(const BoxTable& table) {
  geometry::require_valid(table.boxes, "format_box_table");
  require_length(table.objects.size(), table.boxes.size(), "object");
  require_length(table.scores.size(), table.boxes.size(), "score");
  require_length(table.classes.size(), table.boxes.size(), "class");
  const bool yaw_only = std::all_of(table.boxes.begin(), table.boxes.end(), [](const Box& box) {
    return box.rotation.x() == 0.0 && box.rotation.y() == 0.0;
  });
  std::string text;
  append_header(text, table, yaw_only);
  for (std::size_t row = 0; row < table.boxes.size(); ++row) {
    if (!table.objects.empty()) text.append(std::to_string(table.objects[row])).append(",");
    append_box(text, table.boxes[row], yaw_only);
    if (!table.scores.empty()) {
      text += ',';
      internal::append_number(text, table.scores[row]);
    }
    if (!table.classes.empty()) {
      text += ',';
      append_class(text, table.classes[row]);
    }
    text += '\n';
  }
  return text;
}

void write_box_table(const std::filesystem::path& path, const BoxTable& table) {
  write_file(path, format_box_table(table));
}

BoxTable to_box_table(std::span<const geometry::Detection> detections) {
  BoxTable table;
  for (const auto& detection : detections) {
    table.boxes.push_back(detection.box);
    table.scores.push_back(detection.score);
    table.classes.push_back(detection.label);
  }
  return table;
}

}  // namespace arbox::io

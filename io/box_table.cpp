#include "arbox/io/box_table.h"

#include <algorithm>
#include <array>
#include <optional>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/box_columns.h"
#include "arbox/io/internal/rotation.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

using geometry::Box;
using internal::BoxColumns;
using internal::kBoxColumns;
using internal::kQuaternionColumns;
using internal::LineReader;
using internal::parse_number;
using internal::quoted_text;
using internal::refuse;
using internal::TextPlace;

class RowReader {
 public:
  explicit RowReader(BoxColumns columns) : columns_(std::move(columns)) {
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
    if (fields.size() != columns_.size()) {
      refuse(place,
             std::to_string(columns_.size()) + " fields (" + internal::joined(columns_, " ") + ")",
             std::to_string(fields.size()));
    }
    table.boxes.push_back(read_box(fields, place));
    if (object_) {
      table.objects.push_back(internal::parse_integer(fields[*object_], "object", place));
    }
    if (score_) table.scores.push_back(parse_number(fields[*score_], "score", place));
    if (class_) table.classes.push_back(internal::unquoted(fields[*class_]));
  }

 private:
  std::optional<std::size_t> column(std::string_view name) const {
    const auto found = std::find(columns_.begin(), columns_.end(), name);
    if (found == columns_.end()) return std::nullopt;
    return found - columns_.begin();
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
    if (yaw_) {
      return geometry::make_yaw_box(center, size, parse_number(fields[*yaw_], "yaw", place));
    }
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

  BoxColumns columns_;
  std::array<std::size_t, 6> box_{};
  std::array<std::size_t, 4> quaternion_{};
  std::optional<std::size_t> yaw_, object_, score_, class_;
};

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
  const auto names = internal::split_fields(first);
  const bool header = internal::is_header(names);
  const RowReader reader(header ? internal::header_columns(names, lines.place())
                                : internal::guessed_columns(names, options, lines.place()));
  if (!header) reader.read(names, lines.place(), table);
  while (lines.next_filled())
    reader.read(internal::split_fields(lines.line()), lines.place(), table);
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

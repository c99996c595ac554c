#include "arbox/io/kitti_label.h"

#include <array>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

using internal::LineReader;
using internal::quoted_text;
using internal::refuse;
using internal::TextPlace;

constexpr std::string_view kDontCare = "DontCare";
constexpr std::size_t kLabelFields = 15;
constexpr int kResultDecimals = 4;
constexpr std::array<std::string_view, 16> kFieldNames = {
    "type",   "truncation", "occlusion", "alpha", "left", "top", "right",      "bottom",
    "height", "width",      "length",    "x",     "y",    "z",   "rotation_y", "score"};

enum class LineKind { kLabel, kResult };

void require_label_values(const KittiObject& object, const TextPlace& place) {
  const bool dont_care = object.type == kDontCare;
  const auto came = [](double number) {
    std::string text;
    internal::append_number(text, number);
    return text;
  };
  if (!(object.truncation >= 0 && object.truncation <= 1) &&
      !(dont_care && object.truncation == -1)) {
    refuse(place, "a truncation in [0, 1]", came(object.truncation));
  }
  if ((object.occlusion < 0 || object.occlusion > 3) && !(dont_care && object.occlusion == -1)) {
    refuse(place, "an occlusion of 0, 1, 2 or 3", came(object.occlusion));
  }
  if (object.right < object.left) {
    refuse(place, "left <= right", came(object.left) + " and " + came(object.right));
  }
  if (object.bottom < object.top) {
    refuse(place, "top <= bottom", came(object.top) + " and " + came(object.bottom));
  }
}

void require_sizes(const KittiObject& object, LineKind kind, const TextPlace& place) {
  const std::array<double, 3> sizes = {object.height, object.width, object.length};
  const bool may_lack = kind == LineKind::kResult || object.type == kDontCare;
  if (may_lack && sizes == std::array<double, 3>{-1, -1, -1}) return;
  for (std::size_t i = 0; i < 3; ++i) {
    if (sizes[i] > 0) continue;
    std::string came;
    internal::append_number(came, sizes[i]);
    refuse(place, "a size above zero as " + std::string(kFieldNames[8 + i]), came);
  }
}

int parse_occlusion(double number, const TextPlace& place) {
  // Some writers print it with decimals.
  if (number != std::floor(number) || std::abs(number) > 1e6) {
    std::string came;
    internal::append_number(came, number);
    refuse(place, "a whole number as occlusion", came);
  }
  return static_cast<int>(number);
}

KittiObject parse_object(const LineReader& lines, LineKind kind) {
  const TextPlace place = lines.place();
  const auto fields = internal::split_white_space(lines.line());
  const std::size_t expected = kLabelFields + (kind == LineKind::kResult ? 1 : 0);
  if (fields.size() != expected) {
    refuse(place,
           std::to_string(expected) + " fields of a KITTI " +
               (kind == LineKind::kLabel ? "label" : "result (a label line and a score)"),
           std::to_string(fields.size()));
  }
  std::array<double, 16> v{};
  for (std::size_t i = 1; i < fields.size(); ++i) {
    v[i] = internal::parse_number(fields[i], kFieldNames[i], place);
  }
  KittiObject object{.type = std::string(fields[0]),
                     .truncation = v[1],
                     .occlusion = parse_occlusion(v[2], place),
                     .alpha = v[3],
                     .left = v[4],
                     .top = v[5],
                     .right = v[6],
                     .bottom = v[7],
                     .height = v[8],
                     .width = v[9],
                     .length = v[10],
                     .x = v[11],
                     .y = v[12],
                     .z = v[13],
                     .rotation_y = v[14],
                     .score = v[15]};
  if (kind == LineKind::kLabel) require_label_values(object, place);
  require_sizes(object, kind, place);
  return object;
}

std::vector<KittiObject> parse_objects(std::string_view text, std::string_view source,
                                       LineKind kind) {
  std::vector<KittiObject> objects;
  LineReader lines(text, source);
  while (lines.next_filled()) objects.push_back(parse_object(lines, kind));
  return objects;
}

void append_object(std::string& text, const KittiObject& object, LineKind kind, int decimals) {
  if (object.type.empty() || object.type.find_first_of(" \t\r\n\v\f") != std::string::npos) {
    throw InvalidArgument("format_kitti: a type must be a word without white space, got " +
                          quoted_text(object.type));
  }
  const auto append = [&](double number, int digits) {
    if (!std::isfinite(number)) {
      throw InvalidArgument("format_kitti: a number of an object of type " + object.type +
                            " is not finite");
    }
    text += ' ';
    internal::append_fixed(text, number, digits);
  };
  text += object.type;
  append(object.truncation, object.truncation == -1 ? 0 : 2);
  append(object.occlusion, 0);
  append(object.alpha, object.alpha == -10 ? 0 : decimals);
  for (const double edge : {object.left, object.top, object.right, object.bottom}) {
    append(edge, decimals);
  }
  for (const double size : {object.height, object.width, object.length}) {
    append(size, size == -1 ? 0 : decimals);
  }
  for (const double position : {object.x, object.y, object.z}) {
    append(position, position == -1000 ? 0 : decimals);
  }
  append(object.rotation_y, object.rotation_y == -10 ? 0 : decimals);
  if (kind == LineKind::kResult) append(object.score, 6);
  text += '\n';
}

std::string format_objects(std::span<const KittiObject> objects, LineKind kind, int decimals) {
  std::string text;
  for (const KittiObject& object : objects) append_object(text, object, kind, decimals);
  return text;
}

}  // namespace

bool has_box(const KittiObject& object) {
  return object.height > 0 && object.width > 0 && object.length > 0;
}

std::vector<KittiObject> parse_kitti_labels(std::string_view text, std::string_view source) {
  return parse_objects(text, source, LineKind::kLabel);
}

std::vector<KittiObject> parse_kitti_results(std::string_view text, std::string_view source) {
  return parse_objects(text, source, LineKind::kResult);
}

std::vector<KittiObject> read_kitti_labels(const std::filesystem::path& path) {
  return parse_kitti_labels(read_file(path), path.string());
}

std::vector<KittiObject> read_kitti_results(const std::filesystem::path& path) {
  return parse_kitti_results(read_file(path), path.string());
}

std::string format_kitti_labels(std::span<const KittiObject> objects, int decimals) {
  return format_objects(objects, LineKind::kLabel, decimals);
}

std::string format_kitti_results(std::span<const KittiObject> objects) {
  return format_objects(objects, LineKind::kResult, kResultDecimals);
}

}  // namespace arbox::io

#include "arbox/io/scannet.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "arbox/base/error.h"
#include "arbox/geometry/enclosing_box.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/json.h"

namespace arbox::io {
namespace {

using internal::quoted_text;

constexpr double kMostIds = 9007199254740992.0;
constexpr double kAxisTolerance = 1e-3;
constexpr int kMostNyu40 = 40;

std::int64_t whole(const JsonCursor& value) {
  const double number = value.number();
  if (!(number >= 0 && number < kMostIds) || number != std::floor(number)) {
    value.refuse("a whole number from 0");
  }
  return static_cast<std::int64_t>(number);
}

/// Collects the array `segIndices` of the outermost object without building the rest.
class SegmentReader : public nlohmann::json_sax<nlohmann::json> {
 public:
  SegmentReader(std::string_view source, std::vector<std::int64_t>& segments)
      : source_(source), segments_(segments) {}

  bool found() const { return found_; }

  bool null() override { return other("null"); }
  bool boolean(bool) override { return other("a boolean"); }
  bool number_integer(number_integer_t value) override {
    if (wanted()) refuse("a segment number from 0", std::to_string(value));
    return true;
  }
  bool number_unsigned(number_unsigned_t value) override {
    if (!wanted()) return true;
    if (value >= static_cast<number_unsigned_t>(kMostIds)) {
      refuse("a segment number from 0", std::to_string(value));
    }
    segments_.push_back(static_cast<std::int64_t>(value));
    return true;
  }
  bool number_float(number_float_t, const string_t& text) override { return other(text); }
  bool string(string_t& text) override { return other(quoted_text(text)); }
  bool binary(binary_t&) override { return other("binary"); }
  bool start_object(std::size_t) override {
    other("an object");
    ++depth_;
    return true;
  }
  bool key(string_t& name) override {
    if (depth_ == 1) {
      here_ = name == "segIndices";
      if (here_ && found_) refuse("the key segIndices once", "it a second time");
      found_ |= here_;
    }
    return true;
  }
  bool end_object() override { return --depth_ >= 0; }
  bool start_array(std::size_t) override {
    if (here_ && depth_ == 2) refuse("segment numbers", "an array");
    ++depth_;
    return true;
  }
  bool end_array() override { return --depth_ >= 0; }
  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::detail::exception&) override {
    throw FormatError(std::string(source_) + ": byte " + std::to_string(position) +
                      ": expected JSON");
  }

 private:
  bool wanted() const { return here_ && depth_ == 2; }
  bool other(const std::string& what) {
    if (here_ && depth_ <= 2 && depth_ >= 1) refuse("an array of segment numbers", what);
    return true;
  }
  [[noreturn]] void refuse(const std::string& expected, const std::string& came) const {
    throw FormatError(std::string(source_) + ": segIndices[" + std::to_string(segments_.size()) +
                      "]: expected " + expected + ", got " + came);
  }

  std::string_view source_;
  std::vector<std::int64_t>& segments_;
  int depth_ = 0;
  bool here_ = false, found_ = false;
};

std::size_t column_of(const std::vector<std::string_view>& names, std::string_view wanted,
                      const internal::TextPlace& place) {
  const auto found = std::find(names.begin(), names.end(), wanted);
  if (found == names.end()) {
    internal::refuse(place, "a column " + std::string(wanted), internal::joined(names, " "));
  }
  return static_cast<std::size_t>(found - names.begin());
}

std::vector<std::string_view> split_tabs(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t tab = line.find('\t');
    fields.push_back(line.substr(0, tab));
    if (tab == std::string_view::npos) return fields;
    line.remove_prefix(tab + 1);
  }
}

}  // namespace

std::vector<ScanNetGroup> parse_scannet_aggregation(std::string_view text,
                                                    std::string_view source) {
  const auto values = parse_json_values(text, source);
  if (values.size() != 1) {
    throw FormatError(std::string(source) + ": expected one JSON object with the key segGroups");
  }
  const JsonCursor root(values[0], std::string(source) + ": ");
  root.require_object();
  std::vector<ScanNetGroup> groups;
  for (const JsonCursor& item : root.at("segGroups").elements()) {
    item.require_object();
    ScanNetGroup& group = groups.emplace_back();
    group.object_id = whole(item.at("objectId"));
    group.label = item.at("label").text();
    for (const JsonCursor& segment : item.at("segments").elements()) {
      group.segments.push_back(whole(segment));
    }
  }
  return groups;
}

std::vector<std::int64_t> parse_scannet_segments(std::string_view text, std::string_view source) {
  std::vector<std::int64_t> segments;
  // Two bytes a number at least.
  segments.reserve(text.size() / 8);
  SegmentReader reader(source, segments);
  nlohmann::json::sax_parse(text.begin(), text.end(), &reader);
  if (!reader.found()) {
    throw FormatError(std::string(source) + ": expected an object with the key segIndices");
  }
  return segments;
}

std::string format_scannet_aggregation(std::string_view scene,
                                       std::span<const ScanNetGroup> groups) {
  Json list = Json::array();
  for (const ScanNetGroup& group : groups) {
    list.push_back({{"id", group.object_id},
                    {"objectId", group.object_id},
                    {"segments", group.segments},
                    {"label", group.label}});
  }
  const std::string name(scene);
  return dump_json({{"sceneId", "scannet." + name},
                    {"appId", "Arbox"},
                    {"segGroups", std::move(list)},
                    {"segmentsFile", "scannet." + name + "_vh_clean_2.0.010000.segs.json"}},
                   -1);
}

std::string format_scannet_segments(std::string_view scene,
                                    std::span<const std::int64_t> segments) {
  std::string text = R"({"params":{"kThresh":"0.01","segMinVerts":"20"},"sceneId":)" +
                     dump_json(std::string(scene), -1) + R"(,"segIndices":[)";
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (i > 0) text += ',';
    text += std::to_string(segments[i]);
  }
  return text + "]}";
}

Eigen::Matrix4d parse_scannet_alignment(std::string_view text, std::string_view source) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  internal::LineReader lines(text, source);
  while (lines.next_filled()) {
    const std::string_view line = internal::trimmed(lines.line());
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos ||
        internal::trimmed(line.substr(0, equals)) != "axisAlignment") {
      continue;
    }
    const auto fields = internal::split_white_space(line.substr(equals + 1));
    if (fields.size() != 16) {
      internal::refuse(lines.place(), "16 numbers after axisAlignment",
                       std::to_string(fields.size()));
    }
    for (int i = 0; i < 16; ++i) {
      matrix(i / 4, i % 4) = internal::parse_number(fields[static_cast<std::size_t>(i)],
                                                    "axisAlignment", lines.place());
    }
    const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
    const bool rigid = (turn * turn.transpose()).isIdentity(kAxisTolerance) &&
                       turn.determinant() > 0 &&
                       matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kAxisTolerance);
    if (!rigid) {
      internal::refuse(lines.place(), "a rigid motion after axisAlignment",
                       "a matrix that is none");
    }
  }
  return matrix;
}

std::map<std::string, int> parse_scannet_label_map(std::string_view text, std::string_view source) {
  internal::LineReader lines(text, source);
  if (!lines.next_filled()) {
    internal::refuse(lines.place(), "a table with the columns raw_category and nyu40id",
                     "an empty file");
  }
  const auto names = split_tabs(lines.line());
  const std::size_t category = column_of(names, "raw_category", lines.place());
  const std::size_t id = column_of(names, "nyu40id", lines.place());
  std::map<std::string, int> result;
  while (lines.next_filled()) {
    const auto fields = split_tabs(lines.line());
    if (fields.size() <= std::max(category, id)) {
      internal::refuse(lines.place(), std::to_string(names.size()) + " fields between tabs",
                       std::to_string(fields.size()));
    }
    const std::string_view number = internal::trimmed(fields[id]);
    const std::int64_t value =
        number.empty() ? 0 : internal::parse_integer(number, "nyu40id", lines.place());
    if (value < 0 || value > kMostNyu40) {
      internal::refuse(lines.place(), "an nyu40id of 0..40", std::to_string(value));
    }
    result[std::string(fields[category])] = static_cast<int>(value);
  }
  return result;
}

void align(geometry::PointCloud& cloud, const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
  const Eigen::Vector3d shift = matrix.topRightCorner<3, 1>();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Eigen::Map<Eigen::Vector3f> point(cloud.values.data() + i * cloud.columns());
    point = (turn * point.cast<double>() + shift).cast<float>().eval();
  }
}

std::vector<geometry::Box> instance_boxes(const geometry::PointCloud& cloud,
                                          std::span<const std::int32_t> instance_of_point,
                                          std::size_t instances) {
  if (instance_of_point.size() != cloud.size()) {
    throw InvalidArgument("instance_boxes: expected one instance a point, got " +
                          std::to_string(instance_of_point.size()) + " for " +
                          std::to_string(cloud.size()) + " points");
  }
  std::vector<Eigen::AlignedBox3f> hulls(instances);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::int32_t instance = instance_of_point[i];
    if (instance < 1 || static_cast<std::size_t>(instance) > instances) continue;
    hulls[static_cast<std::size_t>(instance) - 1].extend(cloud.view().position(i));
  }
  std::vector<geometry::Box> boxes(instances);
  for (std::size_t i = 0; i < instances; ++i) {
    boxes[i].size.setZero();
    if (hulls[i].isEmpty()) continue;
    boxes[i].center = ((hulls[i].min() + hulls[i].max()) / 2.0F).cast<double>();
    boxes[i].size = hulls[i].sizes().cast<double>().cwiseMax(geometry::kMinimumBoxSize);
  }
  return boxes;
}

}  // namespace arbox::io

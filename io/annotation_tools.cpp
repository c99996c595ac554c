#include "arbox/io/annotation_tools.h"

#include <algorithm>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <cmath>
#include <numbers>
#include <sstream>

#include "arbox/base/error.h"
#include "arbox/geometry/rotation.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/json.h"
#include "arbox/io/kitti_label.h"

namespace arbox::io {
namespace {

using Tree = boost::property_tree::ptree;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kVertexTolerance = 1e-2;
// What a parser of trees may use of stack.
constexpr int kDeepest = 32;

Eigen::Vector3d vector_at(const JsonCursor& value, const std::array<const char*, 3>& keys) {
  return {value.at(keys[0]).number(), value.at(keys[1]).number(), value.at(keys[2]).number()};
}

geometry::Box checked(const geometry::Box& box, const std::string& place) {
  try {
    geometry::require_valid(box, place);
  } catch (const InvalidArgument& error) {
    throw FormatError(error.what());
  }
  return box;
}

/// labelCloud's vertex 0 is at the low end of length, width and height; 3, 1 and 4 are its
/// neighbours along them.
geometry::Box box_of_vertices(const JsonCursor& value) {
  const auto rows = value.elements();
  if (rows.size() != 8) value.refuse("eight vertices");
  std::array<Eigen::Vector3d, 8> vertices;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 8; ++i) {
    const auto numbers = rows[i].elements();
    if (numbers.size() != 3) rows[i].refuse("three numbers");
    vertices[i] = {numbers[0].number(), numbers[1].number(), numbers[2].number()};
    center += vertices[i] / 8;
  }
  Eigen::Matrix3d axes;
  axes << vertices[3] - vertices[0], vertices[1] - vertices[0], vertices[4] - vertices[0];
  const Eigen::Vector3d size = axes.colwise().norm();
  if (!(size.array() > 0.0).all()) value.refuse("the vertices of a box");
  for (int i = 0; i < 3; ++i) axes.col(i) /= size[i];
  if (!(axes.transpose() * axes).isIdentity(kVertexTolerance) || axes.determinant() < 0.0) {
    value.refuse("the vertices of a box, in labelCloud's order");
  }
  return checked(
      {.center = center, .size = size, .rotation = geometry::Quaternion(axes).normalized()},
      value.place());
}

geometry::Box box_of_centroid(const JsonCursor& value, AngleUnit unit, double& largest) {
  const Eigen::Vector3d angles = vector_at(value.at("rotations"), {"x", "y", "z"});
  largest = std::max(largest, angles.cwiseAbs().maxCoeff());
  const Eigen::Vector3d turn = angles * (unit == AngleUnit::kDegrees ? kDegree : 1.0);
  return checked(
      {.center = vector_at(value.at("centroid"), {"x", "y", "z"}),
       .size = vector_at(value.at("dimensions"), {"length", "width", "height"}),
       .rotation = geometry::to_quaternion(geometry::RollPitchYaw{turn.x(), turn.y(), turn.z()})},
      value.place());
}

/// The depth of nested elements, counted without building them.
int depth_of(std::string_view text) {
  int depth = 0, deepest = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] == '<' && text[i + 1] != '!' && text[i + 1] != '?') {
      depth += text[i + 1] == '/' ? -1 : 1;
      deepest = std::max(deepest, depth);
    } else if (text[i] == '/' && text[i + 1] == '>') {
      --depth;
    }
  }
  return deepest;
}

double number_in(const Tree& tree, const char* key, std::string_view source) {
  const auto child = tree.get_optional<std::string>(key);
  if (!child) {
    throw FormatError(std::string(source) + ": expected an element " + key + " in each item");
  }
  return internal::parse_number(internal::trimmed(*child), key, {source, 0});
}

std::int64_t whole_in(const Tree& tree, const char* key, std::string_view source) {
  const double number = number_in(tree, key, source);
  if (number != std::floor(number) || std::abs(number) > 1e9) {
    throw FormatError(std::string(source) + ": expected a whole number as " + key);
  }
  return static_cast<std::int64_t>(number);
}

/// Poses that only fill the gap between two others: out of the image (2) or behind it (99), also by
/// name, as the exporter writes where it copies poses.
bool is_outside(std::string_view truncation) {
  const std::string_view word = internal::trimmed(truncation);
  return word == "2" || word == "99" || word.ends_with("OUT_IMAGE") ||
         word.ends_with("BEHIND_IMAGE");
}

void read_track(const Tree& item, std::string_view source, Tracklets& tracklets) {
  const std::string label = item.get<std::string>("objectType", "");
  const Eigen::Vector3d size(number_in(item, "w", source), number_in(item, "h", source),
                             number_in(item, "l", source));
  std::int64_t frame = whole_in(item, "first_frame", source);
  const auto poses = item.get_child_optional("poses");
  if (!poses) throw FormatError(std::string(source) + ": expected poses in each item");
  for (const auto& [key, pose] : *poses) {
    if (key != "item") continue;
    const std::int64_t here = frame++;
    if (is_outside(pose.get<std::string>("truncation", ""))) continue;
    const geometry::RollPitchYaw turn{number_in(pose, "rx", source), number_in(pose, "ry", source),
                                      number_in(pose, "rz", source)};
    tracklets[here].push_back(
        {.label = label,
         .box = checked({.center = {number_in(pose, "tx", source), number_in(pose, "ty", source),
                                    number_in(pose, "tz", source)},
                         .size = size,
                         .rotation = geometry::to_quaternion(turn)},
                        std::string(source) + ": frame " + std::to_string(here))});
  }
}

}  // namespace

LabelCloudFile parse_labelcloud_json(std::string_view text, std::string_view source,
                                     AngleUnit unit) {
  const auto values = parse_json_values(text, source);
  if (values.size() != 1 || !values[0].is_object()) {
    throw FormatError(std::string(source) + ": expected one JSON object with the key objects");
  }
  const JsonCursor root(values[0], std::string(source) + ": ");
  LabelCloudFile file;
  if (root.has("filename")) file.cloud = root.at("filename").text();
  for (const JsonCursor& item : root.at("objects").elements()) {
    item.require_object();
    LabeledObject& object = file.objects.emplace_back();
    object.label = item.at("name").text();
    object.box = item.has("vertices") ? box_of_vertices(item.at("vertices"))
                                      : box_of_centroid(item, unit, file.largest_angle);
  }
  return file;
}

std::vector<LabeledObject> parse_labelcloud_kitti(std::string_view text, std::string_view source) {
  std::vector<LabeledObject> objects;
  for (const KittiObject& object : parse_kitti_labels(text, source)) {
    if (!has_box(object)) continue;
    objects.push_back({.label = object.type,
                       .box = geometry::make_yaw_box({object.x, object.y, object.z},
                                                     {object.length, object.width, object.height},
                                                     object.rotation_y)});
  }
  return objects;
}

Tracklets parse_cvat_tracklets(std::string_view text, std::string_view source) {
  if (depth_of(text) > kDeepest) {
    throw FormatError(std::string(source) + ": expected tracklets, got deeply nested elements");
  }
  Tree tree;
  std::istringstream stream{std::string(text)};
  try {
    boost::property_tree::read_xml(stream, tree);
  } catch (const boost::property_tree::xml_parser_error& error) {
    throw FormatError(std::string(source) + ":" + std::to_string(error.line()) +
                      ": expected XML: " + error.message());
  }
  const auto tracks = tree.get_child_optional("boost_serialization.tracklets");
  if (!tracks) {
    throw FormatError(std::string(source) + ": expected boost_serialization with tracklets");
  }
  Tracklets tracklets;
  for (const auto& [key, item] : *tracks) {
    if (key == "item") read_track(item, source, tracklets);
  }
  return tracklets;
}

}  // namespace arbox::io

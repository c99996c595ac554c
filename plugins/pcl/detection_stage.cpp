#include "arbox/plugins/pcl/detection_stage.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "arbox/base/error.h"
#include "arbox/detectors/open_detector.h"
#include "arbox/drawing/color.h"
#include "arbox/geometry/confidence_box.h"
#include "arbox/geometry/quantile_box.h"
#include "arbox/io/wireframe.h"

namespace arbox::pcl {
namespace {

using geometry::Box;
using geometry::Channel;
using geometry::Detection;
using geometry::ScalarType;
using ::pcl::PCLPointField;

/// False for types that channels do not have.
bool to_scalar(std::uint8_t datatype, ScalarType& type) {
  switch (datatype) {
    case PCLPointField::INT8:
      type = ScalarType::kInt8;
      return true;
    case PCLPointField::UINT8:
      type = ScalarType::kUint8;
      return true;
    case PCLPointField::INT16:
      type = ScalarType::kInt16;
      return true;
    case PCLPointField::UINT16:
      type = ScalarType::kUint16;
      return true;
    case PCLPointField::INT32:
      type = ScalarType::kInt32;
      return true;
    case PCLPointField::UINT32:
      type = ScalarType::kUint32;
      return true;
    case PCLPointField::FLOAT32:
      type = ScalarType::kFloat32;
      return true;
    case PCLPointField::FLOAT64:
      type = ScalarType::kFloat64;
      return true;
    default:
      return false;
  }
}

const PCLPointField* find(std::span<const PCLPointField> fields, const char* name) {
  const auto place = std::find_if(fields.begin(), fields.end(),
                                  [&](const PCLPointField& field) { return field.name == name; });
  return place == fields.end() ? nullptr : &*place;
}

/// The byte of x.
std::size_t offset_of_coordinates(std::span<const PCLPointField> fields) {
  const PCLPointField* x = find(fields, "x");
  const PCLPointField* y = find(fields, "y");
  const PCLPointField* z = find(fields, "z");
  const auto is_float = [](const PCLPointField* field) {
    return field != nullptr && field->datatype == PCLPointField::FLOAT32;
  };
  if (!is_float(x) || !is_float(y) || !is_float(z) || y->offset != x->offset + sizeof(float) ||
      z->offset != y->offset + sizeof(float)) {
    throw InvalidArgument(
        "point type: expected registered fields x, y, z, one float after another "
        "(POINT_CLOUD_REGISTER_POINT_STRUCT)");
  }
  return x->offset;
}

/// Turns points into the axes of a box, from its centre, in halves of its size.
struct Inside {
  explicit Inside(const Box& box)
      : center(box.center),
        axes(box.rotation.conjugate().toRotationMatrix()),
        half(0.5 * box.size) {}
  bool operator()(const Eigen::Vector3d& point) const {
    return ((axes * (point - center)).cwiseAbs().array() <= half.array()).all();
  }
  Eigen::Vector3d center;
  Eigen::Matrix3d axes;
  Eigen::Vector3d half;
};

void require_index(::pcl::index_t index, std::size_t count) {
  if (index < 0 || static_cast<std::size_t>(index) >= count) {
    throw InvalidArgument("indices: expected indices of the " + std::to_string(count) +
                          " points of the cloud, got " + std::to_string(index));
  }
}

template <class Asked, class Make>
std::vector<Box> chosen_boxes(std::span<const Detection> detections, double share, const char* what,
                              const Asked& asked, const Make& make) {
  if (!(share > 0.0 && share < 1.0)) {
    throw InvalidArgument(std::string(what) + ": expected a number between 0 and 1, got " +
                          std::to_string(share));
  }
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (const Box* box = asked(detections[i])) {
      boxes.push_back(*box);
    } else if (!detections[i].samples.empty()) {
      boxes.push_back(make(detections[i]));
    } else {
      throw InvalidArgument(std::string(what) + ": detection " + std::to_string(i) +
                            " has neither a box at " + std::to_string(share) +
                            " nor samples: ask the detector for them before detect()");
    }
  }
  return boxes;
}

void append(const Box& box, drawing::Color color, ::pcl::PolygonMesh& mesh) {
  const io::TriangleMesh bars = io::wireframe_mesh(box);
  const std::uint32_t first = mesh.cloud.width;
  const std::uint32_t packed =
      std::uint32_t{color.r} << 16 | std::uint32_t{color.g} << 8 | std::uint32_t{color.b};
  for (const Eigen::Vector3d& vertex : bars.vertices) {
    const std::size_t place = mesh.cloud.data.size();
    mesh.cloud.data.resize(place + mesh.cloud.point_step);
    const Eigen::Vector3f position = vertex.cast<float>();
    std::memcpy(&mesh.cloud.data[place], position.data(), 3 * sizeof(float));
    std::memcpy(&mesh.cloud.data[place + 3 * sizeof(float)], &packed, sizeof packed);
  }
  mesh.cloud.width += static_cast<std::uint32_t>(bars.vertices.size());
  mesh.cloud.row_step = mesh.cloud.width * mesh.cloud.point_step;
  for (const auto& [a, b, c] : bars.triangles) {
    mesh.polygons.emplace_back().vertices = {static_cast<::pcl::index_t>(first + a),
                                             static_cast<::pcl::index_t>(first + b),
                                             static_cast<::pcl::index_t>(first + c)};
  }
}

/// Without vertices; a vertex is x y z rgb.
::pcl::PolygonMesh empty_mesh() {
  ::pcl::PolygonMesh mesh;
  mesh.cloud.height = 1;
  mesh.cloud.is_dense = 1;
  for (const char* name : {"x", "y", "z", "rgb"}) {
    PCLPointField field;
    field.name = name;
    field.offset = mesh.cloud.point_step;
    field.datatype = PCLPointField::FLOAT32;
    field.count = 1;
    mesh.cloud.point_step += sizeof(float);
    mesh.cloud.fields.push_back(field);
  }
  return mesh;
}

}  // namespace

std::vector<Channel> channels_of(std::span<const PCLPointField> fields) {
  offset_of_coordinates(fields);
  std::vector<Channel> channels;
  for (const PCLPointField& field : fields) {
    if (field.name == "x" || field.name == "y" || field.name == "z") continue;
    if (field.name == "rgb" || field.name == "rgba") {
      // PCL packs blue first.
      channels.push_back({"r", field.offset + 2, ScalarType::kUint8});
      channels.push_back({"g", field.offset + 1, ScalarType::kUint8});
      channels.push_back({"b", field.offset, ScalarType::kUint8});
      continue;
    }
    ScalarType type;
    if (!to_scalar(field.datatype, type)) continue;
    for (std::size_t i = 0; i < std::max<std::size_t>(field.count, 1); ++i) {
      const std::string name = field.count > 1 ? field.name + "_" + std::to_string(i) : field.name;
      channels.push_back({name, field.offset + i * geometry::size_of(type), type});
    }
  }
  return channels;
}

geometry::PointCloudView view_of(const void* points, std::size_t count, std::size_t point_size,
                                 std::span<const PCLPointField> fields) {
  return {points, count, point_size, offset_of_coordinates(fields), channels_of(fields)};
}

std::vector<Box> boxes_of(std::span<const Detection> detections) {
  std::vector<Box> boxes;
  for (const Detection& detection : detections) boxes.push_back(detection.box);
  return boxes;
}

std::vector<Box> confidence_boxes_of(std::span<const Detection> detections, double p) {
  return chosen_boxes(
      detections, p, "confidence boxes",
      [&](const Detection& detection) -> const Box* {
        for (const auto& box : detection.confidence_boxes) {
          if (box.p == p) return &box.box;
        }
        return nullptr;
      },
      [&](const Detection& detection) {
        return geometry::confidence_boxes({.boxes = detection.samples}, std::span(&p, 1))[0].box;
      });
}

std::vector<Box> quantile_boxes_of(std::span<const Detection> detections, double q) {
  return chosen_boxes(
      detections, q, "quantile boxes",
      [&](const Detection& detection) -> const Box* {
        for (const auto& box : detection.quantile_boxes) {
          if (box.q == q) return &box.box;
        }
        return nullptr;
      },
      [&](const Detection& detection) {
        return geometry::quantile_boxes(detection.samples, std::span(&q, 1))[0].box;
      });
}

std::vector<::pcl::PointIndices> points_in_boxes(const geometry::PointCloudView& cloud,
                                                 std::span<const Box> boxes,
                                                 const ::pcl::Indices* among) {
  geometry::require_valid(boxes, "points_in_boxes");
  const std::vector<Inside> insides(boxes.begin(), boxes.end());
  std::vector<::pcl::PointIndices> objects(boxes.size());
  const std::size_t count = among == nullptr ? cloud.size() : among->size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto index = among == nullptr ? static_cast<::pcl::index_t>(i) : (*among)[i];
    require_index(index, cloud.size());
    // A coordinate that is not a number compares false with everything.
    const Eigen::Vector3d point = cloud.position(static_cast<std::size_t>(index)).cast<double>();
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      if (insides[b](point)) objects[b].indices.push_back(index);
    }
  }
  for (auto& object : objects) std::sort(object.indices.begin(), object.indices.end());
  return objects;
}

::pcl::PolygonMesh wireframe(std::span<const Detection> detections) {
  ::pcl::PolygonMesh mesh = empty_mesh();
  for (const Detection& detection : detections) {
    append(detection.box, drawing::class_color(detection.label), mesh);
  }
  return mesh;
}

::pcl::PolygonMesh wireframe(std::span<const Box> boxes, const std::string& label) {
  ::pcl::PolygonMesh mesh = empty_mesh();
  for (const Box& box : boxes) append(box, drawing::class_color(label), mesh);
  return mesh;
}

void DetectionStage::setModel(const std::string& name, const std::vector<std::string>& options) {
  detector_ = detectors::open_detector(name, options);
}

void DetectionStage::setDetector(std::shared_ptr<const detectors::Detector> detector) {
  detector_ = std::move(detector);
}

void DetectionStage::run(const void* points, std::size_t count, std::size_t point_size,
                         std::span<const PCLPointField> fields, const ::pcl::Indices* among) {
  if (!detector_) setModel("cluster_fit");
  if (among == nullptr) {
    result_ = detector_->detect(view_of(points, count, point_size, fields), request_);
    return;
  }
  // A view cannot leave points out: those that are asked for are brought together.
  std::vector<std::byte> chosen(among->size() * point_size);
  for (std::size_t i = 0; i < among->size(); ++i) {
    require_index((*among)[i], count);
    std::memcpy(
        chosen.data() + i * point_size,
        static_cast<const std::byte*>(points) + static_cast<std::size_t>((*among)[i]) * point_size,
        point_size);
  }
  result_ = detector_->detect(view_of(chosen.data(), among->size(), point_size, fields), request_);
}

}  // namespace arbox::pcl

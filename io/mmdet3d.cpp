#include "arbox/io/mmdet3d.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "arbox/base/error.h"
#include "arbox/io/numpy_pickle.h"
#include "arbox/io/sunrgbd.h"

namespace arbox::io {
namespace {

constexpr std::size_t kMostBoxes = 1000;
constexpr std::size_t kLeastImageBoxes = 5;
constexpr double kSameNumber = 1e-6;

std::vector<double> numbers_of(const PickleValue& value) {
  return is_numpy(value) ? numpy_array(value).values<double>() : value.numbers();
}

std::string stem_of(const std::string& path) { return std::filesystem::path(path).stem().string(); }

Eigen::Matrix4d matrix4(const PickleValue& value) {
  const std::vector<double> numbers = numbers_of(value);
  if (numbers.size() != 16) value.refuse("a 4 x 4 matrix");
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
}

/// Rows of `columns` numbers, filled up with zeros to N.
template <std::size_t N>
std::vector<std::array<double, N>> rows_of(const PickleValue& value, std::size_t count) {
  const std::vector<double> numbers = numbers_of(value);
  const std::size_t columns = count == 0 ? 0 : numbers.size() / count;
  if (numbers.size() != count * columns || columns > N || (count > 0 && columns + 1 < N)) {
    value.refuse(std::to_string(count) + " rows of " + std::to_string(N) + " numbers");
  }
  std::vector<std::array<double, N>> rows(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(i * columns), columns,
                rows[i].begin());
  }
  return rows;
}

/// Sizes written as (length, height, width) rather than (length, width, height).
std::optional<YawSense> sense_of_dimensions(const PickleValue& dimensions,
                                            const std::vector<std::array<double, 7>>& boxes) {
  const std::vector<double> sizes = numbers_of(dimensions);
  if (sizes.size() != 3 * boxes.size()) return std::nullopt;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const double second = sizes[3 * i + 1], width = boxes[i][4], height = boxes[i][5];
    if (std::abs(width - height) < kSameNumber) continue;
    if (std::abs(second - height) < kSameNumber) return YawSense::kClockwise;
    if (std::abs(second - width) < kSameNumber) return YawSense::kCounterClockwise;
  }
  return std::nullopt;
}

Projection projection_of(const PickleValue& calib) {
  const std::vector<double> tilt = numbers_of(calib.at("Rt"));
  const PickleValue camera = calib.at("K");
  const std::vector<double> intrinsic = numbers_of(camera);
  if (tilt.size() != 9) calib.at("Rt").refuse("a 3 x 3 matrix");
  if (intrinsic.size() != 9) camera.refuse("a 3 x 3 matrix");
  using Rows = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  SunRgbdCalibration calibration;
  calibration.tilt = Rows(tilt.data());
  calibration.intrinsic = Rows(intrinsic.data());
  // The oldest files hold the numbers of the calibration's line, columns first.
  if (intrinsic[2] == 0.0 && intrinsic[6] != 0.0) calibration.intrinsic.transposeInPlace();
  return io::projection_of(calibration);
}

Mmdet3dInfo read_old(const PickleValue& info) {
  Mmdet3dInfo result;
  const PickleValue cloud = info.at("point_cloud");
  if (const auto features = cloud.find("num_features")) result.columns = features->length();
  const auto path = info.find("pts_path");
  if (path) {
    result.points = path->text();
  } else {
    const PickleValue index = cloud.at("lidar_idx");
    const std::string digits =
        index.is(PickleKind::kText) ? std::string(index.text()) : std::to_string(index.integer());
    const std::size_t missing = digits.size() < 6 ? 6 - digits.size() : 0;
    result.points = "points/" + std::string(missing, '0') + digits + ".bin";
  }
  result.name = stem_of(result.points);
  if (const auto image = info.find("image")) {
    if (const auto file = image->find("image_path")) result.image = file->text();
  }
  if (const auto calib = info.find("calib")) result.projection = projection_of(*calib);
  const auto annos = info.find("annos");
  result.labelled = annos.has_value();
  if (!annos) return result;
  if (const auto matrix = annos->find("axis_align_matrix")) result.alignment = matrix4(*matrix);
  const PickleValue gt_num = annos->at("gt_num");
  const auto count = static_cast<std::size_t>(
      is_numpy(gt_num) ? numpy_array(gt_num).values<double>().at(0) : gt_num.number());
  if (count == 0) return result;
  result.labels = numpy_texts(annos->at("name")).values;
  if (result.labels.size() != count) annos->at("name").refuse(std::to_string(count) + " names");
  result.boxes = rows_of<7>(annos->at("gt_boxes_upright_depth"), count);
  if (const auto boxes = annos->find("bbox")) result.image_boxes = rows_of<4>(*boxes, count);
  if (const auto sizes = annos->find("dimensions")) {
    result.written_sense = sense_of_dimensions(*sizes, result.boxes);
  }
  return result;
}

using Categories = std::map<std::int64_t, std::string>;

Categories read_categories(const PickleValue& root) {
  Categories categories;
  const PickleValue names = root.at("metainfo").at("categories");
  for (std::size_t i = 0; i < names.size(); ++i) {
    categories[names.value(i).integer()] = names.key(i).text();
  }
  return categories;
}

void read_instance(const PickleValue& instance, const Categories& categories, Mmdet3dInfo& info) {
  const PickleValue number = instance.at("bbox_label_3d");
  const std::int64_t label =
      is_numpy(number) ? numpy_array(number).values<std::int64_t>().at(0) : number.integer();
  const auto found = categories.find(label);
  if (label < 0 || found == categories.end()) return;
  info.labels.push_back(found->second);
  info.boxes.push_back(rows_of<7>(instance.at("bbox_3d"), 1)[0]);
  if (const auto box = instance.find("bbox")) {
    info.image_boxes.push_back(rows_of<4>(*box, 1)[0]);
  }
}

Mmdet3dInfo read_new(const PickleValue& info, const Categories& categories) {
  Mmdet3dInfo result;
  const PickleValue cloud = info.at("lidar_points");
  result.points = cloud.at("lidar_path").text();
  if (const auto features = cloud.find("num_pts_feats")) result.columns = features->length();
  result.name = stem_of(result.points);
  for (const PickleValue& place : {info, cloud}) {
    if (const auto matrix = place.find("axis_align_matrix")) {
      result.alignment = matrix4(*matrix);
      break;
    }
  }
  if (const auto images = info.find("images")) {
    const PickleValue camera = images->at("CAM0");
    if (const auto file = camera.find("img_path")) result.image = file->text();
    if (const auto matrix = camera.find("depth2img")) {
      const std::vector<double> numbers = numbers_of(*matrix);
      const int columns = numbers.size() == 9 ? 3 : 4;
      if (numbers.size() != 9 && numbers.size() != 12 && numbers.size() != 16) {
        matrix->refuse("a 3 x 3 or 4 x 4 matrix");
      }
      result.projection = Projection::Zero();
      for (int i = 0; i < 3 * columns; ++i) {
        (*result.projection)(i / columns, i % columns) = numbers[static_cast<std::size_t>(i)];
      }
    }
  }
  const auto instances = info.find("instances");
  result.labelled = instances.has_value();
  if (!instances) return result;
  for (const PickleValue& instance : instances->elements()) {
    read_instance(instance, categories, result);
  }
  if (result.image_boxes.size() != result.boxes.size()) result.image_boxes.clear();
  return result;
}

double image_overlap(const std::array<double, 7>& box, double yaw, const Projection& projection,
                     const std::array<double, 4>& seen) {
  Eigen::AlignedBox2d hull;
  const auto turned =
      geometry::make_yaw_box({box[0], box[1], box[2]}, {box[3], box[4], box[5]}, yaw);
  for (const Eigen::Vector3d& corner : geometry::corners(turned)) {
    const Eigen::Vector3d pixel = projection * corner.homogeneous();
    if (!(pixel.z() > 0.1)) return 0.0;
    hull.extend((pixel.head<2>() / pixel.z()).eval());
  }
  const Eigen::AlignedBox2d given(Eigen::Vector2d(seen[0], seen[1]),
                                  Eigen::Vector2d(seen[2], seen[3]));
  const Eigen::AlignedBox2d both = hull.intersection(given);
  const double common = both.isEmpty() ? 0.0 : both.volume();
  return common / std::max(hull.volume() + given.volume() - common, 1e-9);
}

}  // namespace

std::vector<Mmdet3dInfo> read_mmdet3d_infos(const PickleValue& root) {
  std::vector<Mmdet3dInfo> infos;
  if (root.is(PickleKind::kList)) {
    for (const PickleValue& info : root.elements()) infos.push_back(read_old(info));
    return infos;
  }
  const Categories categories = read_categories(root);
  const auto yaw = root.at("metainfo").find("yaw");
  for (const PickleValue& info : root.at("data_list").elements()) {
    infos.push_back(read_new(info, categories));
    if (yaw && yaw->text() == "counter-clockwise") {
      infos.back().written_sense = YawSense::kCounterClockwise;
    }
  }
  return infos;
}

std::optional<YawSense> find_yaw_sense(const std::vector<Mmdet3dInfo>& infos) {
  double clockwise = 0.0, counter = 0.0;
  std::size_t boxes = 0;
  for (const Mmdet3dInfo& info : infos) {
    if (!info.projection || info.image_boxes.size() != info.boxes.size()) continue;
    for (std::size_t i = 0; i < info.boxes.size() && boxes < kMostBoxes; ++i) {
      const auto& box = info.boxes[i];
      // Boxes along the axes and square ones look alike in both senses.
      if (std::abs(std::sin(2 * box[6])) < 0.2 || std::abs(box[3] - box[4]) < 0.1) continue;
      ++boxes;
      counter += image_overlap(box, box[6], *info.projection, info.image_boxes[i]);
      clockwise += image_overlap(box, -box[6], *info.projection, info.image_boxes[i]);
    }
  }
  if (boxes >= kLeastImageBoxes &&
      std::abs(clockwise - counter) > 0.02 * static_cast<double>(boxes)) {
    return clockwise > counter ? YawSense::kClockwise : YawSense::kCounterClockwise;
  }
  for (const Mmdet3dInfo& info : infos) {
    if (info.written_sense) return info.written_sense;
  }
  return std::nullopt;
}

}  // namespace arbox::io

#include "arbox/io/sunrgbd.h"

#include <gtest/gtest.h>
#include <matio.h>
#include <zlib.h>

#include <fstream>

#include "arbox/geometry/rotation.h"
#include "arbox/io/dataset.h"
#include "arbox/io/file.h"
#include "arbox/io/npz.h"
#include "io/expect_refusal.h"
#include "support/program.h"

namespace arbox {
namespace {

using io::parse_sunrgbd_calibration;
using io::parse_sunrgbd_labels;
using testing::expect_refusal;
using testing::TemporaryDirectory;

constexpr const char* kLine = "bed 10 20 30 40 1 2 3 0.5 1 0.25 0 -2\n";

TEST(SunRgbd, HalfSizesAndHeadingsBecomeBoxes) {
  const auto labels = parse_sunrgbd_labels(kLine, "l");
  ASSERT_EQ(labels.size(), 1u);
  const auto object = io::to_object(labels[0]);
  EXPECT_EQ(object.box.size, Eigen::Vector3d(2, 1, 0.5));
  EXPECT_NEAR(geometry::yaw(object.box), -M_PI / 2, 1e-12);
  EXPECT_EQ(object.attributes.at("right"), 40.0);
  EXPECT_EQ(object.attributes.at("bottom"), 60.0);
  const auto again = parse_sunrgbd_labels(
      io::format_sunrgbd_labels(std::vector{io::to_sunrgbd_label(object)}), "l");
  EXPECT_LE((again[0].half_size - labels[0].half_size).norm(), 1e-9);
  EXPECT_LE((again[0].heading - Eigen::Vector2d(0, -1)).norm(), 1e-9);
  EXPECT_EQ(again[0].width, 30.0);
}

TEST(SunRgbd, ParsersRefuseWhatIsWrong) {
  expect_refusal([] { parse_sunrgbd_labels("bed 1 2 3\n", "l"); }, {"l:1", "13 fields", "4"});
  expect_refusal([] { parse_sunrgbd_labels("bed 1 2 3 4 1 2 3 0 1 1 0 1\n", "l"); }, {"c1"});
  expect_refusal([] { parse_sunrgbd_labels("bed 1 2 3 4 1 2 3 1 1 1 0 0\n", "l"); }, {"ox oy"});
  expect_refusal([] { parse_sunrgbd_labels("bed 1 2 3 4 1 nan 3 1 1 1 0 1\n", "l"); }, {"cy"});
  EXPECT_EQ(parse_sunrgbd_labels("bed 1 2 3 4 1 2 3 -1 1 1 0 1\n", "l")[0].half_size.x(), 1.0);
  expect_refusal([] { parse_sunrgbd_calibration("1 0 0 0 1 0 0 0 1\n", "c"); }, {"K"});
  expect_refusal([] { parse_sunrgbd_calibration("2 0 0 0 1 0 0 0 1\n1 0 0 0 1 0 0 0 1\n", "c"); },
                 {"rotation"});
  expect_refusal([] { parse_sunrgbd_calibration("1 0 0 0 1 0 0 0 1\n0 0 0 0 1 0 0 0 1\n", "c"); },
                 {"singular"});
}

TEST(SunRgbd, CalibrationsComeBackFromTheirProjection) {
  io::SunRgbdCalibration calibration;
  calibration.tilt = Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 0.3, 0.1).normalized()).matrix();
  calibration.intrinsic << 529.5, 0, 365, 0, 530, 265, 0, 0, 1;
  const auto projection = io::projection_of(calibration);
  // What lies ahead is seen in the middle of the image.
  const Eigen::Vector3d ahead = calibration.tilt * Eigen::Vector3d(0, 2, 0);
  const Eigen::Vector3d pixel = projection * ahead.homogeneous();
  EXPECT_TRUE((pixel / pixel.z()).isApprox(Eigen::Vector3d(365, 265, 1), 1e-12));
  EXPECT_NEAR(pixel.z(), 2.0, 1e-12);
  const auto again = io::calibration_of(projection);
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->tilt.isApprox(calibration.tilt, 1e-12));
  EXPECT_TRUE(again->intrinsic.isApprox(calibration.intrinsic, 1e-12));
  EXPECT_FALSE(io::calibration_of(io::Projection::Zero()));
  const auto text = io::parse_sunrgbd_calibration(io::format_sunrgbd_calibration(calibration), "c");
  EXPECT_EQ(text.tilt, calibration.tilt);
}

/// Rows of gt_boxes_test5050 of one class and image.
std::vector<std::array<double, 10>> true_boxes(const std::filesystem::path& root,
                                               const std::string& label, int image) {
  std::ifstream ids(root / (label + "_gt_imgids.txt")), rows(root / (label + "_gt_boxes.dat"));
  std::vector<std::array<double, 10>> result;
  int id = 0;
  while (ids >> id) {
    std::array<double, 10> row;
    for (double& number : row) rows >> number;
    if (id == image) result.push_back(row);
  }
  return result;
}

/// The largest distance of the row's corners and heights from the nearest ones of the box.
double distance(const std::array<double, 10>& row, const geometry::Box& box) {
  double largest = std::max(std::abs(box.center.z() - box.size.z() / 2 - row[8]),
                            std::abs(box.center.z() + box.size.z() / 2 - row[9]));
  for (int c = 0; c < 4; ++c) {
    double nearest = 1e9;
    for (const auto& corner : geometry::corners(box)) {
      nearest = std::min(nearest,
                         (corner.head<2>() - Eigen::Vector2d(row[2 * c], row[2 * c + 1])).norm());
    }
    largest = std::max(largest, nearest);
  }
  return largest;
}

TEST(SunRgbd, SampleImagesAgreeWithTheTestSetsBoxes) {
  ARBOX_REQUIRE_DATA(root, "sunrgbd");
  double worst = 0.0;
  int compared = 0;
  for (const char* version : {"v1", "v2"}) {
    const auto dataset = io::open_dataset(root / "sunrgbd_trainval", {.sunrgbd_labels = version});
    EXPECT_EQ(dataset->layout(), "sunrgbd");
    EXPECT_EQ(dataset->names("all"), (std::vector<std::string>{"000001", "000002", "000003"}));
    for (const std::string& name : dataset->names("all")) {
      const auto scene = dataset->load("all", name);
      EXPECT_GT(scene.cloud.size(), 100000u);
      ASSERT_TRUE(scene.photo);
      for (const auto& object : scene.objects) {
        double best = 1e9;
        for (const auto& row :
             true_boxes(root / "gt_boxes_test5050", object.label, std::stoi(name))) {
          best = std::min(best, distance(row, object.box));
        }
        // One box of the second version was drawn anew.
        if (std::string(version) == "v2" && best > 0.3) continue;
        worst = std::max(worst, best);
        ++compared;
        EXPECT_LE(best, 0.0025) << name << " " << object.label;
      }
    }
  }
  EXPECT_GE(compared, 14);
  RecordProperty("worst_mm", std::to_string(1000 * worst));
}

TEST(SunRgbd, PhotosShowTheirPointsInTheirColours) {
  ARBOX_REQUIRE_DATA(root, "sunrgbd/sunrgbd_trainval");
  const auto scene = io::open_dataset(root)->load("all", "000001");
  // Every point of the cloud was seen by the camera, at the pixel that it projects to.
  std::size_t inside = 0;
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
    const Eigen::Vector3d pixel =
        scene.photo->projection * scene.cloud.view().position(i).cast<double>().homogeneous();
    const Eigen::Vector2d at = pixel.head<2>() / pixel.z();
    inside += pixel.z() > 0 && at.x() > -2 && at.x() < 732 && at.y() > -2 && at.y() < 532;
  }
  EXPECT_EQ(inside, scene.cloud.size());
}

TEST(SunRgbd, VotenetFilesAgreeWithTheLabels) {
  ARBOX_REQUIRE_DATA(root, "sunrgbd");
  const auto prepared = io::open_dataset(root);
  EXPECT_EQ(prepared->layout(), "sunrgbd-votenet");
  EXPECT_EQ(prepared->splits(), (std::vector<std::string>{"train", "val", "all"}));
  const auto scene = prepared->load("val", "000001");
  const auto labels =
      io::open_dataset(root / "sunrgbd_trainval", {.sunrgbd_labels = "v1"})->load("all", "000001");
  ASSERT_EQ(scene.objects.size(), labels.objects.size());
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    EXPECT_EQ(scene.objects[i].label, labels.objects[i].label);
    EXPECT_LE((scene.objects[i].box.center - labels.objects[i].box.center).norm(), 1e-6);
    EXPECT_LE((scene.objects[i].box.size - labels.objects[i].box.size).norm(), 1e-6);
    EXPECT_LE(
        geometry::rotation_distance(scene.objects[i].box.rotation, labels.objects[i].box.rotation),
        1e-5);
  }
}

TEST(SunRgbd, VotesAreThoseOfVotenet) {
  ARBOX_REQUIRE_DATA(root, "sunrgbd");
  const TemporaryDirectory folder;
  const auto scene = io::open_dataset(root)->load("train", "000001");
  const auto writer = io::create_dataset(folder / "out", "sunrgbd-votenet");
  writer->add("train", scene);
  writer->finish();
  const auto votes = [](const std::filesystem::path& path) {
    return io::open_npz(path).read("point_votes").values<float>();
  };
  const auto ours = votes(folder / "out/sunrgbd_pc_bbox_votes_50k_v1_train/000001_votes.npz");
  const auto theirs = votes(root / "sunrgbd_pc_bbox_votes_50k_v1_train/000001_votes.npz");
  ASSERT_EQ(ours.size(), theirs.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < ours.size(); i += 10) {
    for (std::size_t c = 0; c < 10; ++c) {
      if (std::abs(ours[i + c] - theirs[i + c]) > 1e-4F) {
        ++different;
        break;
      }
    }
  }
  // Points on a face are in or out by rounding.
  EXPECT_LE(different, 20u);
}

/// A MAT-file with the toolbox' structs, made with the library that reads it.
void write_toolbox(const std::filesystem::path& path) {
  const auto numbers = [](const char* name, std::vector<double> values, std::size_t rows) {
    std::size_t sizes[2] = {rows, values.size() / rows};
    return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, sizes, values.data(), 0);
  };
  const auto text = [](const char* name, std::string value) {
    std::size_t sizes[2] = {1, value.size()};
    return Mat_VarCreate(name, MAT_C_CHAR, MAT_T_UTF8, 2, sizes, value.data(), 0);
  };
  const char* object_fields[] = {"basis",       "coeffs", "centroid", "classname",
                                 "orientation", "gtBb2D", nullptr};
  std::size_t one[2] = {1, 1}, two[2] = {1, 2}, none[2] = {0, 0};
  matvar_t* objects = Mat_VarCreateStruct2("groundtruth3DBB", 2, two, object_fields);
  for (std::size_t i = 0; i < 2; ++i) {
    // Rows of the basis: up last; the second row points against the heading.
    Mat_VarSetStructFieldByName(objects, "basis", i,
                                numbers("basis", {0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1}, 3));
    Mat_VarSetStructFieldByName(objects, "coeffs", i, numbers("coeffs", {0.5, 1, 0.25}, 1));
    Mat_VarSetStructFieldByName(objects, "centroid", i, numbers("centroid", {1, 2, 3}, 1));
    Mat_VarSetStructFieldByName(objects, "classname", i,
                                text("classname", i == 0 ? "bed" : "lamp"));
    Mat_VarSetStructFieldByName(objects, "orientation", i,
                                numbers("orientation", {0.6, -0.8, 0}, 1));
    Mat_VarSetStructFieldByName(objects, "gtBb2D", i, numbers("gtBb2D", {10, 20, 30, 40}, 1));
  }
  const char* fields[] = {"groundtruth3DBB", "Rtilt", "K", nullptr};
  matvar_t* meta = Mat_VarCreateStruct2("SUNRGBDMeta", 2, two, fields);
  for (std::size_t i = 0; i < 2; ++i) {
    Mat_VarSetStructFieldByName(meta, "Rtilt", i, numbers("Rtilt", {1, 0, 0, 0, 1, 0, 0, 0, 1}, 3));
    Mat_VarSetStructFieldByName(meta, "K", i, numbers("K", {500, 0, 0, 0, 500, 0, 320, 240, 1}, 3));
  }
  Mat_VarSetStructFieldByName(meta, "groundtruth3DBB", 0, objects);
  Mat_VarSetStructFieldByName(
      meta, "groundtruth3DBB", 1,
      Mat_VarCreate("groundtruth3DBB", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, none, nullptr, 0));
  static_cast<void>(one);
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  Mat_VarWrite(file, meta, MAT_COMPRESSION_ZLIB);
  Mat_VarFree(meta);
  Mat_Close(file);
}

TEST(SunRgbd, ToolboxAnnotationsBecomeTheSameBoxesAsLabels) {
  const TemporaryDirectory folder;
  write_toolbox(folder / "SUNRGBDMeta3DBB_v2.mat");
  const auto annotations = io::read_sunrgbd_toolbox(folder / "SUNRGBDMeta3DBB_v2.mat");
  ASSERT_EQ(annotations.size(), 2u);
  EXPECT_TRUE(annotations[1].objects.empty());
  EXPECT_EQ(annotations[0].calibration.intrinsic(0, 2), 320.0);
  ASSERT_EQ(annotations[0].objects.size(), 2u);
  const auto& object = annotations[0].objects[0];
  const auto label =
      io::to_object(parse_sunrgbd_labels("bed 10 20 30 40 1 2 3 0.5 1 0.25 0.6 -0.8\n", "l")[0]);
  EXPECT_EQ(object.label, "bed");
  EXPECT_LE((object.box.size - label.box.size).norm(), 1e-12);
  EXPECT_LE(geometry::rotation_distance(object.box.rotation, label.box.rotation), 1e-7);
  EXPECT_EQ(object.attributes, label.attributes);
  const auto dataset = io::open_dataset(folder.path());
  EXPECT_EQ(dataset->layout(), "sunrgbd-toolbox");
  EXPECT_EQ(dataset->load("all", "000001").objects.size(), 1u);
}

TEST(SunRgbd, WrittenToolboxAnnotationsComeBack) {
  const TemporaryDirectory folder;
  const auto file = folder / "SUNRGBDMeta3DBB_v2.mat";
  io::SunRgbdAnnotation annotation{.number = 3, .calibration = {}, .objects = {}};
  annotation.calibration.intrinsic << 500, 0, 320, 0, 510, 240, 0, 0, 1;
  annotation.objects = {
      io::to_object(parse_sunrgbd_labels("bed 10 20 30 40 1 2 3 0.5 1 0.25 0.6 -0.8\n", "l")[0])};
  annotation.objects[0].label = "coffee table \xC3\xA9";
  io::write_sunrgbd_toolbox(file, {{annotation}});
  const auto read = io::read_sunrgbd_toolbox(file);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].number, 3u);
  EXPECT_EQ(read[0].calibration.intrinsic, annotation.calibration.intrinsic);
  EXPECT_EQ(read[0].objects[0].label, annotation.objects[0].label);
  EXPECT_EQ(read[0].objects[0].attributes, annotation.objects[0].attributes);
  EXPECT_LE((read[0].objects[0].box.size - annotation.objects[0].box.size).norm(), 1e-12);
  EXPECT_LE(geometry::rotation_distance(read[0].objects[0].box.rotation,
                                        annotation.objects[0].box.rotation),
            1e-7);
  io::write_sunrgbd_toolbox(file, {});
  EXPECT_TRUE(io::read_sunrgbd_toolbox(file).empty());
  expect_refusal([&] { io::write_sunrgbd_toolbox(file, std::vector(2, annotation)); }, {"3"});
  annotation.objects[0].box.rotation = Eigen::AngleAxisd(1, Eigen::Vector3d::UnitX());
  expect_refusal([&] { io::write_sunrgbd_toolbox(file, {{annotation}}); }, {"upright"});
}

/// A MAT-file of one uncompressed matrix `instance` of doubles that claims `rows` x `columns`.
std::string claiming(std::uint32_t rows, std::uint32_t columns, std::uint32_t bytes = 48) {
  std::string file = "MATLAB 5.0 MAT-file";
  file.resize(124, ' ');
  const auto word = [&](std::uint32_t value) {
    file.append(reinterpret_cast<const char*>(&value), 4);
  };
  file += std::string("\0\1IM", 4);
  word(14), word(56 + bytes);
  word(6), word(8), word(6), word(0);
  word(5), word(8), word(rows), word(columns);
  word(1), word(8);
  file += "instance";
  word(9), word(bytes);
  return file + std::string(bytes, '\0');
}

TEST(SunRgbd, SizesThatAMatFileClaimsAreComparedWithItsBytes) {
  const TemporaryDirectory folder;
  const auto read = [&](const std::string& content) {
    return io::read_sunrgbd_toolbox(folder.write("a.mat", content));
  };
  // Read as far as to the missing variable: all sizes fit.
  expect_refusal([&] { read(claiming(1, 6)); }, {"a.mat", "SUNRGBDMeta"});
  for (const auto& [rows, columns] : {std::pair{2, 6}, {1 << 30, 6}, {-1, 6}, {1 << 30, 1 << 30}}) {
    expect_refusal([&] { read(claiming(rows, columns)); }, {"a.mat", "expected"});
  }
  std::string longer = claiming(1, 6);
  longer[132] = 127;
  expect_refusal([&] { read(longer); }, {"bytes to lie in"});
  std::string sparse = claiming(1, 6);
  sparse[144] = 5;
  expect_refusal([&] { read(sparse); }, {"sparse", "class 5"});
  std::string big_endian = claiming(1, 6);
  std::swap(big_endian[126], big_endian[127]);
  expect_refusal([&] { read(big_endian); }, {"little-endian"});
  // 64 MB of zeros in 64 kB.
  std::string bomb = claiming(1, 8 << 20, 64 << 20).substr(128), packed(1 << 20, '\0');
  uLongf size = packed.size();
  ASSERT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                     reinterpret_cast<const Bytef*>(bomb.data()), bomb.size()),
            Z_OK);
  packed.resize(size);
  const auto length = static_cast<std::uint32_t>(size);
  std::string file = claiming(1, 6).substr(0, 128) + std::string("\x0F\0\0\0", 4);
  file.append(reinterpret_cast<const char*>(&length), 4).append(packed);
  expect_refusal([&] { read(file); }, {"unpack to 4"});
  file.resize(file.size() / 2);
  expect_refusal([&] { read(file); }, {"a.mat"});
}

TEST(SunRgbd, BrokenMatFilesAreRefused) {
  const TemporaryDirectory folder;
  const auto file = folder / "SUNRGBDMeta3DBB_v2.mat";
  write_toolbox(file);
  const std::string whole = io::read_file(file);
  for (const std::size_t size : {0u, 60u, 128u, 140u, 300u}) {
    folder.write("short.mat", whole.substr(0, size));
    expect_refusal([&] { io::read_sunrgbd_toolbox(folder / "short.mat"); }, {"short.mat"});
  }
  folder.write("hdf.mat", "MATLAB 7.3 MAT-file" + std::string(200, ' '));
  expect_refusal([&] { io::read_sunrgbd_toolbox(folder / "hdf.mat"); }, {"-v7"});
}

}  // namespace
}  // namespace arbox

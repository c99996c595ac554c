#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/io/point_cloud_file.h"
#include "io/expect_refusal.h"
#include "support/program.h"

namespace arbox::io {
namespace {

using arbox::testing::expect_refusal;

geometry::PointCloud cloud(const std::vector<std::string>& channels, std::size_t count) {
  geometry::PointCloud result{.channels = channels, .values = {}};
  std::uint64_t state = 1;
  const auto next = [&] {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<float>(state >> 40) / 16777216.0F;
  };
  for (std::size_t i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) result.values.push_back(200.0F * next() - 100.0F);
    for (const auto& channel : channels) {
      const float value = next();
      const bool color = channel.size() == 1;
      const bool whole = channel == "ring" || channel == "label";
      result.values.push_back(color   ? std::round(value * 255.0F) / 255.0F
                              : whole ? std::floor(value * 64.0F)
                                      : value);
    }
  }
  return result;
}

struct Form {
  PointCloudFormat format;
  std::string encoding;
};

class RoundTrip : public ::testing::TestWithParam<Form> {};

TEST_P(RoundTrip, KeepsEveryPointAndChannelExactly) {
  const auto& [format, encoding] = GetParam();
  for (const std::size_t count : {0U, 1U, 2U, 1000U, 20000U}) {
    for (const std::vector<std::string>& channels :
         {std::vector<std::string>{},
          {"intensity"},
          {"r", "g", "b"},
          {"intensity", "ring", "time", "normal_x", "normal_y", "normal_z", "r", "g", "b", "label",
           "curvature"}}) {
      const auto points = cloud(channels, count);
      const std::string bytes = encode_point_cloud(points.view(), format, {.encoding = encoding});
      ReadOptions options;
      if (format == PointCloudFormat::kNpy || format == PointCloudFormat::kNpz) {
        options.channels = {"x", "y", "z"};
        options.channels.insert(options.channels.end(), channels.begin(), channels.end());
      }
      const auto file = parse_point_cloud(bytes, "-", options);
      EXPECT_EQ(file.format, format);
      EXPECT_EQ(file.points_in_file, count);
      EXPECT_EQ(file.unused_bytes, 0U);
      EXPECT_EQ(file.points.channels, channels);
      EXPECT_EQ(file.points.values, points.values) << count << " " << channels.size();
    }
  }
}

TEST(PointCloudWriter, RefusesNamesThatReadersWouldSplit) {
  for (const std::string name : {"two words", "a,b", "a;b", "tab\t", "line\n", "\"q\"", "", "x"}) {
    const auto points = cloud({"intensity", name}, 2);
    for (const auto format :
         {PointCloudFormat::kPcd, PointCloudFormat::kPly, PointCloudFormat::kText}) {
      EXPECT_THROW(encode_point_cloud(points.view(), format), InvalidArgument) << name;
    }
    EXPECT_NO_THROW(encode_point_cloud(points.view(), PointCloudFormat::kNpy)) << name;
  }
  EXPECT_THROW(encode_point_cloud(cloud({"a", "a"}, 2).view(), PointCloudFormat::kPcd),
               InvalidArgument);
}

INSTANTIATE_TEST_SUITE_P(
    Formats, RoundTrip,
    ::testing::Values(Form{PointCloudFormat::kPcd, "ascii"}, Form{PointCloudFormat::kPcd, "binary"},
                      Form{PointCloudFormat::kPcd, "binary_compressed"},
                      Form{PointCloudFormat::kPly, "ascii"}, Form{PointCloudFormat::kPly, "binary"},
                      Form{PointCloudFormat::kNpy, ""}, Form{PointCloudFormat::kNpz, ""},
                      Form{PointCloudFormat::kText, ""}),
    [](const auto& form) {
      const std::string& encoding = form.param.encoding;
      return std::string(name_of(form.param.format)) + (encoding.empty() ? "" : "_" + encoding);
    });

TEST(BinRoundTrip, WritesFourNumbersUnlessChannelsAreNamed) {
  const auto points = cloud({"ring", "intensity"}, 1001);
  const auto four = encode_point_cloud(points.view(), PointCloudFormat::kBin);
  EXPECT_EQ(four.size(), 1001U * 16);
  const auto read = parse_point_cloud(four, "a.bin");
  EXPECT_THAT(read.points.channels, ::testing::ElementsAre("intensity"));
  EXPECT_EQ(read.points.values[7], points.values[9]);
  const auto five = encode_point_cloud(points.view(), PointCloudFormat::kBin,
                                       {.channels = {"intensity", "ring"}});
  EXPECT_EQ(five.size(), 1001U * 20);
  EXPECT_EQ(parse_point_cloud(five, "a.bin", {.channels = {"5"}}).points.channels,
            (std::vector<std::string>{"intensity", "ring"}));
  const auto bare =
      parse_point_cloud(encode_point_cloud(cloud({}, 7).view(), PointCloudFormat::kBin), "a.bin");
  EXPECT_EQ(bare.points.size(), 7U);
  EXPECT_EQ(bare.points.values[3], 0.0F);
}

TEST(PointCloudWriter, TakesViewsWithByteColorsAndStrides) {
  struct Point {
    double unused;
    float x, y, z;
    std::uint8_t r, g, b;
    std::uint16_t ring;
  };
  const Point points[] = {{0, 1, 2, 3, 255, 128, 0, 7}, {0, 4, 5, 6, 1, 2, 3, 8}};
  using geometry::ScalarType;
  const geometry::PointCloudView view(points, 2, sizeof(Point), offsetof(Point, x),
                                      {{"r", offsetof(Point, r), ScalarType::kUint8},
                                       {"g", offsetof(Point, g), ScalarType::kUint8},
                                       {"b", offsetof(Point, b), ScalarType::kUint8},
                                       {"ring", offsetof(Point, ring), ScalarType::kUint16}});
  for (const auto format :
       {PointCloudFormat::kPcd, PointCloudFormat::kPly, PointCloudFormat::kText}) {
    const auto file = parse_point_cloud(encode_point_cloud(view, format), "-");
    EXPECT_EQ(file.points.values, (std::vector<float>{1, 2, 3, 1, 128 / 255.0F, 0, 7, 4, 5, 6,
                                                      1 / 255.0F, 2 / 255.0F, 3 / 255.0F, 8}));
  }
}

TEST(PointCloudWriter, RefusesWhatDoesNotFit) {
  const auto points = cloud({"intensity"}, 2);
  expect_refusal(
      [&] { encode_point_cloud(points.view(), PointCloudFormat::kPcd, {.channels = {"ring"}}); },
      {"no channel 'ring'", "intensity"});
  expect_refusal(
      [&] { encode_point_cloud(points.view(), PointCloudFormat::kNpy, {.encoding = "ascii"}); },
      {"npy has no encoding 'ascii'"});
  expect_refusal([&] { write_point_cloud("a.jpg", points.view()); }, {"a.jpg", "extension"});
  expect_refusal([&] { write_point_cloud("a.pcd", points.view(), {.format = "las"}); }, {"'las'"});
  expect_refusal([&] { write_point_cloud("/no/such/folder/a.pcd", points.view()); },
                 {"/no/such/folder/a.pcd", "cannot be written"});
}

TEST(PointCloudWriter, WritesTheFormatOfTheExtension) {
  const arbox::testing::TemporaryDirectory folder;
  const auto points = cloud({"intensity"}, 101);
  for (const char* name : {"b.PCD", "a.ply", "c.bin", "d.npy", "e.npz", "f.csv", "g.txt"}) {
    write_point_cloud(folder / name, points.view());
    EXPECT_EQ(read_point_cloud(folder / name).points.values, points.values) << name;
  }
  std::filesystem::create_directory(folder / "folder.pcd");
  folder.write("notes.md", "x");
  std::vector<std::string> names;
  for (const auto& path : list_point_clouds(folder.path())) names.push_back(path.filename());
  EXPECT_THAT(names, ::testing::ElementsAre("a.ply", "b.PCD", "c.bin", "d.npy", "e.npz", "f.csv"));
  expect_refusal([&] { list_point_clouds(folder / "none"); }, {"none", "cannot be listed"});
  expect_refusal([&] { read_point_cloud(folder / "folder.pcd"); }, {"folder.pcd", "a directory"});
  expect_refusal([&] { read_point_cloud(folder / "none.pcd"); }, {"none.pcd", "no such file"});
}

}  // namespace
}  // namespace arbox::io

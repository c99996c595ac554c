#include "arbox/io/point_cloud_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "arbox/base/error.h"
#include "arbox/io/npz.h"
#include "io/expect_refusal.h"
#include "support/program.h"

namespace arbox::io {
namespace {

using arbox::testing::expect_refusal;
using ::testing::ElementsAre;

template <class T>
std::string bytes_of(std::initializer_list<T> values) {
  return {reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(T)};
}

std::string pcd(const std::string& fields, const std::string& sizes, const std::string& types,
                const std::string& counts, std::size_t points, const std::string& body) {
  const std::string number = std::to_string(points);
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + sizes + "\nTYPE " + types +
         "\nCOUNT " + counts + "\nWIDTH " + number +
         "\nHEIGHT 1\nVIEWPOINT 1 2 3 0.5 0.5 0.5 0.5\n" + "POINTS " + number + "\nDATA " + body;
}

std::string xyz_pcd(std::size_t points, const std::string& body) {
  return pcd("x y z", "4 4 4", "F F F", "1 1 1", points, body);
}

TEST(Pcd, ReadsAnyOrderTypeAndCount) {
  const std::string text = pcd("ring _ z normal y rgb intensity x timestamp", "2 1 4 4 8 4 1 4 8",
                               "U U F F F U U I F", "1 3 1 3 1 1 1 1 1", 2,
                               "ascii\n7 0 0 0 3.5 0 0 1 2e0 16711935 255 -1 1600000000.5\n"
                               "65535 0 0 0 nan 1 0 0 -2 1 51 12 1600000002\n");
  const auto file = parse_point_cloud(text, "a.pcd", {.keep_non_finite = true});
  EXPECT_THAT(file.points.channels, ElementsAre("ring", "normal_0", "normal_1", "normal_2", "r",
                                                "g", "b", "intensity", "time"));
  EXPECT_EQ(file.non_finite, 1U);
  EXPECT_EQ(file.dropped, 0U);
  EXPECT_EQ(file.time_origin, 1600000000.5);
  EXPECT_EQ(file.intensity_divisor, 255.0);
  EXPECT_THAT(file.viewpoint, ElementsAre(1, 2, 3, 0.5, 0.5, 0.5, 0.5));
  const auto& v = file.points.values;
  ASSERT_EQ(v.size(), 24U);
  EXPECT_THAT(std::vector<float>(v.begin(), v.begin() + 12),
              ElementsAre(-1, 2, 3.5F, 7, 0, 0, 1, 1, 0, 1, 1, 0));
  EXPECT_EQ(v[12], 12.0F);
  EXPECT_TRUE(std::isnan(v[14]));
  EXPECT_THAT(std::vector<float>(v.begin() + 15, v.end()),
              ElementsAre(65535, 1, 0, 0, 0, 0, 1 / 255.0F, 0.2F, 1.5F));
}

TEST(Pcd, ReadsBinaryRecordsWithPadding) {
  std::string body = "binary\n";
  for (const float base : {1.0F, 10.0F}) {
    body += bytes_of<float>({base, base + 1, base + 2}) + "pad!" + bytes_of<float>({base / 20});
  }
  const auto file = parse_point_cloud(
      pcd("x y z _ intensity", "4 4 4 1 4", "F F F U F", "1 1 1 4 1", 2, body + "tail"), "a.pcd");
  EXPECT_THAT(file.points.values, ElementsAre(1, 2, 3, 0.05F, 10, 11, 12, 0.5F));
  EXPECT_EQ(file.unused_bytes, 4U);
}

TEST(Pcd, DropsNonFinitePointsAndCountsThem) {
  const auto file =
      parse_point_cloud(xyz_pcd(4, "ascii\n1 2 3\nnan 0 0\n0 -inf 0\n4 5 6\n"), "a.pcd");
  EXPECT_THAT(file.points.values, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_EQ(file.points_in_file, 4U);
  EXPECT_EQ(file.non_finite, 2U);
  EXPECT_EQ(file.dropped, 2U);
}

TEST(Pcd, ACloudWithoutPointsIsAResult) {
  for (const char* data : {"ascii\n", "binary\n", "binary_compressed\n", "ascii"}) {
    const auto file = parse_point_cloud(xyz_pcd(0, data), "a.pcd");
    EXPECT_TRUE(file.points.view().empty()) << data;
  }
}

TEST(Pcd, RefusesBadFilesWithPlaceAndReason) {
  const auto refuse = [](const std::string& content, const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_point_cloud(content, "a.pcd"); }, parts);
  };
  refuse("", {"a.pcd", "empty file"});
  refuse("VERSION 0.7\nFIELDS x y z\n", {"a.pcd:2", "ends with DATA", "end of the file"});
  refuse(xyz_pcd(2, "ascii\n1 2 3\n4 5\n"), {"a.pcd:13", "expected 3 numbers, got 2"});
  refuse(xyz_pcd(2, "ascii\n1 2 3\n4 5 6 7\n"), {"a.pcd:13", "expected 3 numbers, got 4"});
  refuse(xyz_pcd(2, "ascii\n1 2 3\n4 five 6\n"), {"a.pcd:13", "float32 as y", "'five'"});
  refuse(xyz_pcd(2, "ascii\n1 2 3\n"), {"a.pcd:12", "expected 2 points", "1 before the end"});
  refuse(xyz_pcd(1, "ascii\n1 2 3\n4 5 6\n"), {"a.pcd:13", "expected 1 points", "more"});
  refuse(xyz_pcd(2, "binary\n" + std::string(23, 'x')),
         {"a.pcd: byte", "expected 24 bytes", "got 23"});
  refuse(xyz_pcd(2, "binary_compressed\nabc"), {"expected 8 bytes", "got 3"});
  refuse(xyz_pcd(2, "binary_compressed\n" + bytes_of<std::uint32_t>({50, 24})),
         {"expected 50 bytes of compressed data, got 0"});
  refuse(xyz_pcd(2, "binary_compressed\n" + bytes_of<std::uint32_t>({0, 23})),
         {"expected 24 uncompressed bytes", "got 23"});
  refuse(xyz_pcd(2, "binary_compressed\n" + bytes_of<std::uint32_t>({2, 24}) + "\x20\x20"),
         {"damaged"});
  refuse(xyz_pcd(2, "zipped\n"), {"a.pcd:11", "'zipped'"});
  refuse(pcd("x y q", "4 4 4", "F F F", "1 1 1", 0, "ascii\n"),
         {"expected fields x, y and z", "q"});
  refuse(pcd("x y z x", "4 4 4 4", "F F F F", "1 1 1 1", 0, "ascii\n"), {"'x' comes twice"});
  refuse(pcd("x y z", "4 4", "F F F", "1 1 1", 0, "ascii\n"),
         {"a.pcd:4", "3 words after SIZE", "got 2"});
  refuse(pcd("x y z", "4 4 3", "F F F", "1 1 1", 0, "ascii\n"), {"a.pcd:5", "'F' of size 3"});
  refuse(pcd("x y z", "4 4 4", "F F F", "1 1 -1", 0, "ascii\n"), {"a.pcd:6", "'-1'"});
  refuse(pcd("x y z", "4 4 4", "F F F", "1 1 999999999999", 0, "ascii\n"),
         {"a.pcd:6", "at most 4096"});
  refuse("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 2\nPOINTS 3\nDATA ascii\n",
         {"a.pcd:6", "WIDTH times HEIGHT, 4, got 3"});
  refuse("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nDATA ascii\n", {"WIDTH before DATA"});
  expect_refusal([] { parse_point_cloud(xyz_pcd(0, "ascii\n"), "a.pcd", {.channels = {"4"}}); },
                 {"option channels"});
}

TEST(PointCloudFile, AbsurdCountsAllocateNothing) {
  for (const char* data : {"ascii\n1 2 3\n", "binary\n123", "binary_compressed\n12345678"}) {
    for (const std::size_t points : {std::size_t{1'000'000'000'000}, SIZE_MAX}) {
      expect_refusal([&] { parse_point_cloud(xyz_pcd(points, data), "a.pcd"); }, {"a.pcd"});
    }
  }
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const char* properties : {"", "property list uchar int extra\n"}) {
      for (const char* count : {"1000000000000", "18446744073709551615"}) {
        const std::string content = "ply\nformat " + std::string(format) + " 1.0\nelement vertex " +
                                    count +
                                    "\nproperty float x\nproperty float y\nproperty float z\n" +
                                    properties + "end_header\n1 2 3\n";
        expect_refusal([&] { parse_point_cloud(content, "a.ply"); }, {"a.ply", count});
      }
    }
  }
}

TEST(Ply, ReadsEveryEncodingWithListsAndOtherElements) {
  const std::string header =
      "element camera 1\nproperty list uchar short values\nelement vertex 2\nproperty double x\n"
      "property list uchar ushort neighbours\nproperty float y\nproperty short z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
      "property float nx\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const auto expect_points = [](const std::string& content, const std::string& encoding) {
    const auto file = parse_point_cloud(content, "-");
    EXPECT_EQ(file.encoding, encoding);
    EXPECT_THAT(file.points.channels, ElementsAre("r", "g", "b", "normal_x"));
    EXPECT_THAT(file.points.values,
                ElementsAre(1.5F, 2, -3, 1, 0, 0.2F, 0.5F, 4, 5, 6, 0, 1, 0, -0.5F));
  };
  expect_points("ply\r\nformat ascii 1.0\r\ncomment made here\r\n" + header +
                    "2 7 8\r\n1.5 1 9 2 -3 255 0 51 255 0.5\n4 0 5 6 0 255 0 0 -0.5\n3 0 1 0\n",
                "ascii");
  for (const bool big : {false, true}) {
    std::string body;
    const auto append = [&](auto value) {
      std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
      if (big) std::reverse(bytes.begin(), bytes.end());
      body += bytes;
    };
    const auto byte = [&](int value) { body += static_cast<char>(value); };
    byte(2), append(std::int16_t{7}), append(std::int16_t{8});
    append(1.5), byte(1), append(std::uint16_t{9}), append(2.0F), append(std::int16_t{-3});
    byte(255), byte(0), byte(51), byte(255), append(0.5F);
    append(4.0), byte(0), append(5.0F), append(std::int16_t{6});
    byte(0), byte(255), byte(0), byte(0), append(-0.5F);
    const std::string encoding = big ? "binary_big_endian" : "binary_little_endian";
    const std::string start = "ply\nformat " + encoding + " 1.0\n" + header;
    expect_points(start + body, encoding);
    for (std::size_t length = 0; length < body.size(); ++length) {
      expect_refusal([&] { parse_point_cloud(start + body.substr(0, length), "a.ply"); },
                     {"a.ply: "});
    }
  }
}

TEST(Ply, RefusesBadFilesWithPlaceAndReason) {
  const auto refuse = [](const std::string& content, const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_point_cloud(content, "a.ply"); }, parts);
  };
  const std::string vertex =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
  refuse("", {"a.ply", "empty file"});
  refuse("solid\n", {"a.ply:1", "'solid'"});
  refuse("ply\nformat ascii 2.0\n", {"a.ply:2", "1.0"});
  refuse("ply\n" + vertex + "end_header\n1 2 3\n4 5 6\n", {"a.ply:6", "format before end_header"});
  refuse("ply\nformat ascii 1.0\n" + vertex, {"a.ply:6", "ends with end_header"});
  refuse("ply\nformat ascii 1.0\n" + vertex + "property quad w\n", {"a.ply:7", "'quad'"});
  refuse("ply\nformat ascii 1.0\nproperty float x\n", {"a.ply:3", "an element before"});
  refuse("ply\nformat ascii 1.0\nelement face -1\n", {"a.ply:3", "'-1'"});
  refuse("ply\nformat ascii 1.0\nelement face 0\nend_header\n", {"'vertex', got none"});
  refuse("ply\nformat ascii 1.0\n" + vertex + "end_header\n1 2 3\n4 x 6\n",
         {"a.ply:9", "as y", "'x'"});
  refuse("ply\nformat ascii 1.0\n" + vertex + "end_header\n1 2 3\n4 5\n",
         {"a.ply:9", "3 numbers, got 2"});
  refuse("ply\nformat ascii 1.0\n" + vertex + "end_header\n1 2 3\n",
         {"expected 2 vertices", "1 before"});
  refuse("ply\nformat binary_little_endian 1.0\n" + vertex + "end_header\n" + std::string(20, 'x'),
         {"a.ply: byte ", "2 records of 12 bytes of element 'vertex', got 20 bytes"});
}

TEST(Bin, TheSizeOrTheOptionSaysTheColumns) {
  const std::string sixteen(16 * 4, '\0');
  EXPECT_EQ(parse_point_cloud(sixteen, "a.bin").points.channels,
            std::vector<std::string>{"intensity"});
  EXPECT_EQ(parse_point_cloud(std::string(20 * 4, '\0'), "a.bin").points.size(), 5U);
  EXPECT_EQ(parse_point_cloud(std::string(12, '\0'), "a.bin").points.channels.size(), 0U);
  EXPECT_THAT(parse_point_cloud(std::string(20, '\0'), "a.bin").points.channels,
              ElementsAre("intensity", "ring"));
  EXPECT_THAT(
      parse_point_cloud(std::string(240, '\0'), "a.bin", {.channels = {"6"}}).points.channels,
      ElementsAre("r", "g", "b"));
  EXPECT_THAT(
      parse_point_cloud(std::string(240, '\0'), "a.bin", {.channels = {"z", "_", "y", "x", "ring"}})
          .points.channels,
      ElementsAre("ring"));
}

TEST(Bin, RefusesAmbiguityWithTheCandidates) {
  const auto refuse = [](const std::string& content, const ReadOptions& options,
                         const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_point_cloud(content, "a.bin", options); }, parts);
  };
  refuse("", {}, {"a.bin", "empty file"});
  refuse(std::string(60, '\0'), {}, {"a.bin", "3 or 5 float32", "option channels"});
  refuse(std::string(24, '\0'), {}, {"3 or 6 float32"});
  refuse(std::string(17, '\0'), {}, {"3, 4, 5 or 6 float32", "got 17 bytes"});
  refuse(std::string(17, '\0'), {.channels = {"4"}}, {"16 bytes", "got 17 bytes", "byte 16"});
  refuse(std::string(16, '\0'), {.channels = {"2"}}, {"3 to 4096 columns, got 2"});
  std::string colors, rings, plain;
  for (int i = 0; i < 20; ++i) {
    const auto f = static_cast<float>(i);
    colors += bytes_of<float>({f / 3, -f, 1, 200, f, 3});
    rings += bytes_of<float>({f / 3, -f, 1.5F, 0.25F, f});
    plain += bytes_of<float>({f / 7, -f / 3, 1.5F});
  }
  refuse(colors, {}, {"3, 4, 5 or 6 float32", "look like colours"});
  refuse(rings, {}, {"4 or 5 float32", "looks like a ring"});
  refuse(plain, {}, {"3, 4, 5 or 6", "often negative"});
  EXPECT_EQ(parse_point_cloud(plain, "a.bin", {.channels = {"3"}}).points.size(), 20U);
}

TEST(Text, ReadsEveryDelimiterHeaderAndComment) {
  const auto read = [](const std::string& content, const ReadOptions& options = {}) {
    return parse_point_cloud(content, "a.txt", options);
  };
  const std::vector<float> two{1, 2, 3, 0.5F, 4, 5, -6, 1};
  for (const char* text :
       {"1,2,3,.5\n4,5,-6e0,+1\n", "1 2 3 0.5\n4\t5  -6 1", "1;2;3;0.5;\r\n4;5;-6;1;\r\n",
        "x,y,z,Intensity\n1, 2, 3, 0.5\n4, 5, -6, 1\n",
        "\xef\xbb\xbf\"X\" \"Y\" \"Z\" i\n1 2 3 .5\n4 5 -6 1\n",
        "# a comment\n//X Y Z intensity\n1 2 3 .5\n# middle\n\n4 5 -6 1\n",
        "2\n1 2 3 0.5\n4 5 -6 1\n"}) {
    const auto file = read(text);
    EXPECT_EQ(file.points.values, two) << text;
    EXPECT_THAT(file.points.channels, ElementsAre("intensity")) << text;
  }
  EXPECT_THAT(read("z,t,y,x\n1,5,2,3\n").points.channels, ElementsAre("time"));
  EXPECT_THAT(read("1 2 3 0 -1 0\n").points.channels,
              ElementsAre("normal_x", "normal_y", "normal_z"));
  EXPECT_THAT(read("1 2 3 255 0 51\n").points.values, ElementsAre(1, 2, 3, 1, 0, 0.2F));
  EXPECT_THAT(read("1 2 3 9\n", {.channels = {"x", "_", "y", "z"}}).points.values,
              ElementsAre(1, 3, 9));
  EXPECT_THAT(read("1 2 3 51\n").points.values.back(), 0.2F);
  EXPECT_THAT(read("1 2 3 51\n", {.scale_intensity = false}).points.values.back(), 51.0F);
  EXPECT_TRUE(read("x,y,z\n").points.view().empty());
  EXPECT_THAT(read("1e400 2 3\n1e-400 2 3\n").points.values, ElementsAre(0, 2, 3));
}

TEST(Text, RefusesBadLinesWithTheirNumber) {
  const auto refuse = [](const std::string& content, const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_point_cloud(content, "a.csv"); }, parts);
  };
  refuse("", {"a.csv", "empty file"});
  refuse("# only a comment\n", {"rows of numbers, got none"});
  refuse("a,b,c\n1,2,3\n", {"a.csv:1", "names x, y and z"});
  refuse("1,2,3\n4,5\n", {"a.csv:2", "3 numbers, got 2"});
  refuse("1,2,3\n\n4,5,6,7\n", {"a.csv:3", "3 numbers, got 4"});
  refuse("x;y;z\n1,5;2;3\n", {"a.csv:2", "number as x", "'1,5'"});
  refuse("1,2,3\n4,,6\n", {"a.csv:2", "column 2", "''"});
  refuse("1,2\n", {"at least 3 columns"});
  refuse("3\n1 2 3\n4 5 6\n", {"expected 3 points", "got 2"});
}

TEST(Arrays, ReadAsPointsWithNamedOrUsualColumns) {
  const std::vector<double> numbers{1, 2, 3, 200, 10, 51, 4, 5, 6, 0, 0, 255};
  const auto six = encode_npy<double>(numbers, {2, 6});
  const auto file = parse_point_cloud(six, "a.npy");
  EXPECT_THAT(file.points.channels, ElementsAre("r", "g", "b"));
  EXPECT_EQ(file.points.values[5], 0.2F);
  const auto image = parse_point_cloud(encode_npy<double>(numbers, {2, 2, 3}), "a.npy");
  EXPECT_EQ(image.width * 10 + image.height, 22U);
  EXPECT_EQ(image.points.size(), 4U);
  const auto archive = encode_npz({{"pc", six}, {"labels", encode_npy<double>(numbers, {12})}});
  EXPECT_EQ(parse_point_cloud(archive, "a.npz").points.size(), 2U);
  const auto refuse = [](const std::string& content, const ReadOptions& options,
                         const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_point_cloud(content, "a.npz", options); }, parts);
  };
  refuse(archive, {.array = "labels"}, {"a.npz: array 'labels'", "(N, C)", "(12)"});
  refuse(archive, {.array = "pcs"}, {"no array 'pcs'", "pc and labels"});
  refuse(encode_npz({{"a", six}, {"b", six}}), {}, {"a or b", "option array"});
  refuse(encode_npy<double>(numbers, {6, 2}), {}, {"3 <= C"});
  refuse(six, {.channels = {"5"}}, {"expected the 5 columns", "got 6"});
}

TEST(PointCloudFile, ContentWinsOverTheExtension) {
  EXPECT_EQ(parse_point_cloud(xyz_pcd(0, "ascii\n"), "a.ply").format, PointCloudFormat::kPcd);
  EXPECT_EQ(parse_point_cloud("1 2 3\n", "-").format, PointCloudFormat::kText);
  EXPECT_EQ(parse_point_cloud(std::string(16, '\0'), "-", {.format = "bin"}).points.size(), 1U);
  expect_refusal([] { parse_point_cloud(std::string(16, '\0'), "-"); },
                 {"neither the content nor the extension", "'\\x00"});
  // Bytes that are no letters do not reach the terminal.
  expect_refusal([] { parse_point_cloud("\x9a\xc3(9\x01", "-"); }, {"'\\x9a\\xc3(9\\x01'"});
  expect_refusal([] { parse_point_cloud("1 2 3\n", "-", {.format = "las"}); }, {"'las'"});
}

TEST(PointCloudFile, ReadsRealScansAndArrays) {
  ARBOX_REQUIRE_DATA(scan, "kitti/training/velodyne/000008.bin");
  const auto kitti = read_point_cloud(scan);
  EXPECT_EQ(kitti.points.size(), std::filesystem::file_size(scan) / 16);
  EXPECT_EQ(kitti.intensity_divisor, 1.0);
  ARBOX_REQUIRE_DATA(room, "scannet/scannet_train_detection_data/scene0000_00_vert.npy");
  const auto scannet = read_point_cloud(room);
  EXPECT_EQ(scannet.points.size(), 50000U);
  EXPECT_LE(*std::max_element(scannet.points.values.begin(), scannet.points.values.end()), 10.0F);
  ARBOX_REQUIRE_DATA(other, "scannet/points/scene0113_00.bin");
  expect_refusal([&] { read_point_cloud(other); }, {"scene0113_00.bin", "look like colours"});
  EXPECT_EQ(read_point_cloud(other, {.channels = {"6"}}).points.size(), 91598U);
  ARBOX_REQUIRE_DATA(depth, "binpicking/gqcnn/clutter/primesense/depth_0.npy");
  expect_refusal([&] { read_point_cloud(depth); }, {"(480, 640, 1)"});
}

}  // namespace
}  // namespace arbox::io

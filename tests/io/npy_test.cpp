#include "arbox/io/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "arbox/base/error.h"
#include "arbox/io/npz.h"
#include "support/program.h"

namespace arbox::io {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string file(std::string dictionary, const std::string& data, char version = 1) {
  std::string bytes = "\x93NUMPY";
  bytes += {version, '\0', static_cast<char>(dictionary.size()), '\0'};
  if (version > 1) bytes += {'\0', '\0'};
  return bytes + dictionary + data;
}

std::string message(const std::string& bytes) {
  try {
    parse_npy(bytes, "a.npy");
  } catch (const FormatError& error) {
    return error.what();
  }
  return "no error";
}

template <class T>
class NpyRoundTrip : public ::testing::Test {};
using Types =
    ::testing::Types<float, double, std::int32_t, std::int64_t, std::uint8_t, std::uint32_t>;
TYPED_TEST_SUITE(NpyRoundTrip, Types);

TYPED_TEST(NpyRoundTrip, GivesTheSameNumbersAndShape) {
  std::vector<TypeParam> values(24);
  std::iota(values.begin(), values.end(), TypeParam(1));
  values[3] = std::numeric_limits<TypeParam>::max();
  values[4] = std::numeric_limits<TypeParam>::lowest();
  const auto bytes = encode_npy<TypeParam>(values, {2, 3, 4});
  EXPECT_EQ(bytes.size() - values.size() * sizeof(TypeParam), 128U);
  const NpyArray array = parse_npy(bytes, "a.npy");
  EXPECT_THAT(array.shape(), ElementsAre(2, 3, 4));
  EXPECT_EQ(array.template values<TypeParam>(), values);
}

// The bytes are what numpy.save writes for these arrays.
TEST(Npy, ReadsFortranOrderHalvesAndBigEndian) {
  const std::string halves("\x3c\x00\x7c\x00\xfc\x00\x00\x01\x80\x00\x04\x00", 12);
  const auto array = parse_npy(
      file("{'descr': '>f2', 'fortran_order': True, 'shape': (3, 2), }\n", halves, 2), "");
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  // Columns (1, inf, -inf) and (2^-24, -0, 2^-14) in C order.
  EXPECT_THAT(array.values<double>(), ElementsAre(1.0, std::ldexp(1.0, -24), kInfinity, -0.0,
                                                  -kInfinity, std::ldexp(1.0, -14)));
}

TEST(Npy, EveryHalfNumberConvertsExactly) {
  for (unsigned bits = 0; bits < 65536; ++bits) {
    const float value = half_to_float(static_cast<unsigned short>(bits));
    const unsigned exponent = bits >> 10 & 31, fraction = bits & 1023;
    const double sign = bits >> 15 != 0 ? -1.0 : 1.0;
    if (exponent == 31) {
      EXPECT_EQ(std::isnan(value), fraction != 0);
      continue;
    }
    const double expected = exponent == 0
                                ? sign * fraction / 16777216.0
                                : sign * (1.0 + fraction / 1024.0) * std::pow(2.0, exponent - 15.0);
    ASSERT_EQ(value, expected) << bits;
  }
}

TEST(Npy, AcceptsEveryHeaderSpellingThatNumpyWrites) {
  for (const char version : {1, 2, 3}) {
    const auto array = parse_npy(
        file("{\"shape\": (3L,), 'descr': '|b1', 'fortran_order': False}", {1, 0, 1}, version), "");
    EXPECT_THAT(array.values<std::uint8_t>(), ElementsAre(1, 0, 1));
  }
  EXPECT_EQ(parse_npy(file("{'descr': '<i2', 'fortran_order': False, 'shape': ()}", "\5\1"), "")
                .values<std::int32_t>(),
            std::vector<std::int32_t>{261});
  EXPECT_EQ(parse_npy(encode_npy<float>({}, {0, 4}), "").size(), 0U);
}

TEST(Npy, RefusesIntegersThatDoNotFit) {
  const std::vector<double> values{1.0, 2.5};
  const auto array = parse_npy(encode_npy<double>(values, {2}), "");
  EXPECT_THROW(array.values<std::int32_t>(), InvalidArgument);
  const std::vector<std::int64_t> large{std::int64_t{1} << 40, -1};
  EXPECT_THROW(parse_npy(encode_npy<std::int64_t>(large, {2}), "").values<std::int32_t>(),
               InvalidArgument);
  EXPECT_THROW(encode_npy<double>(values, {3}), InvalidArgument);
}

TEST(Npy, RefusesBadFilesWithTheReason) {
  EXPECT_THAT(message(""), HasSubstr("a.npy: expected a npy file, got an empty file"));
  EXPECT_THAT(message("hello"), HasSubstr("got 'hello'"));
  EXPECT_THAT(message("\x93NUMPY\1"), HasSubstr("ends after"));
  EXPECT_THAT(message(file("", "", 4)), HasSubstr("got 4"));
  const auto header = [](const std::string& type, const std::string& shape) {
    return "{'descr': " + type + ", 'fortran_order': False, 'shape': " + shape + ", }";
  };
  EXPECT_THAT(message(file(header("'<f4'", "(3, 4)"), std::string(44, 'x'))),
              HasSubstr("expected 48 bytes of data for shape (3, 4) of float32, got 44"));
  EXPECT_THAT(message(file(header("'<f4'", "(1000000000000, 4)"), "")),
              HasSubstr("expected 16000000000000 bytes"));
  EXPECT_THAT(message(file(header("'<f4'", "(9223372036854775807, 9223372036854775807)"), "")),
              HasSubstr("expected more than 2^63 bytes"));
  EXPECT_THAT(message(file(header("'<f4'", "(0, 9223372036854775807, 4)"), "")), HasSubstr("2^63"));
  EXPECT_THAT(message(file(header("'|O'", "(3,)"), "")), HasSubstr("got '|O'"));
  EXPECT_THAT(message(file(header("[('x', '<f4')]", "(3,)"), "")), HasSubstr("structured"));
  EXPECT_THAT(message(file(header("'<f4'", "(-3,)"), "")), HasSubstr("'-3'"));
  EXPECT_THAT(message(file("{'descr': '<f4'}", "")), HasSubstr("expected the keys"));
  const std::string good = encode_npy<float>(std::vector<float>(6), {6});
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_NE(message(good.substr(0, length)), "no error") << length;
  }
}

TEST(Npz, RoundTripKeepsNamesAndArrays) {
  const std::vector<float> points{1, 2, 3, 4, 5, 6};
  const std::vector<std::int64_t> labels{7, -8};
  const std::string bytes = encode_npz({{"pc", encode_npy<float>(points, {2, 3})},
                                        {"labels", encode_npy<std::int64_t>(labels, {2})}});
  const NpzFile archive(bytes, "a.npz");
  EXPECT_THAT(archive.names(), ElementsAre("pc", "labels"));
  EXPECT_EQ(archive.read("pc").values<float>(), points);
  EXPECT_EQ(archive.read("labels").values<std::int64_t>(), labels);
  EXPECT_EQ(bytes, encode_npz({{"pc", encode_npy<float>(points, {2, 3})},
                               {"labels", encode_npy<std::int64_t>(labels, {2})}}));
}

TEST(Npz, RefusesBadArchives) {
  EXPECT_THROW(NpzFile("", "a.npz"), FormatError);
  EXPECT_THROW(NpzFile("not a zip", "a.npz"), FormatError);
  const std::string good = encode_npz({{"pc", encode_npy<float>(std::vector<float>(64), {64})}});
  EXPECT_THROW(NpzFile(good, "a.npz").read("points"), InvalidArgument);
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_THROW(NpzFile(good.substr(0, length), "a.npz").read("pc"), FormatError) << length;
  }
}

TEST(Npz, StopsAtTheLimitOfAZipBomb) {
  const std::vector<std::uint8_t> zeros(32 << 20);
  const std::string bomb = encode_npz({{"pc", encode_npy<std::uint8_t>(zeros, {zeros.size()})}});
  EXPECT_LT(bomb.size(), 64U << 10);
  EXPECT_EQ(NpzFile(bomb, "a.npz").read("pc").size(), zeros.size());
  try {
    NpzFile(bomb, "a.npz", 1 << 20).read("pc");
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("a.npz: array 'pc'"), HasSubstr("limit of 1048576")));
  }
}

TEST(Npz, ReadsRealArchives) {
  ARBOX_REQUIRE_DATA(path, "sunrgbd/sunrgbd_pc_bbox_votes_50k_v1_val/000001_pc.npz");
  const NpyArray points = open_npz(path).read("pc");
  EXPECT_EQ(points.shape(), (std::vector<std::size_t>{50000, 6}));
  for (const float value : points.values<float>()) ASSERT_TRUE(std::isfinite(value));
}

}  // namespace
}  // namespace arbox::io

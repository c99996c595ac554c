#include "arbox/io/known_sizes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/program.h"
#include "support/refusal.h"

namespace arbox::io {
namespace {

using ::arbox::testing::refusal;
using ::arbox::testing::TemporaryDirectory;
using ::testing::HasSubstr;

TEST(KnownSizes, AreReadByClassInTheOrderOfTheFile) {
  const KnownSizeTable table = parse_known_sizes(
      "class,l,w,h,name\r\nCar,4.28,1.79,1.49,Golf\n\nTruck,7.5,2.5,3.2,\nCar,4.9,1.87,1.45,\"A, "
      "B\"\n",
      "fleet.csv");
  ASSERT_EQ(table.sizes.size(), 2u);
  const auto& cars = table.sizes.at("Car");
  ASSERT_EQ(cars.size(), 2u);
  EXPECT_EQ(cars[0].name, "Golf");
  EXPECT_EQ(cars[0].size, Eigen::Vector3d(4.28, 1.79, 1.49));
  EXPECT_EQ(cars[1].name, "A, B");
  EXPECT_EQ(table.sizes.at("Truck")[0].name, "");
  EXPECT_EQ(table.lines.at("Car"), 2u);
  EXPECT_EQ(table.lines.at("Truck"), 4u);
}

TEST(KnownSizes, NeedNoHeaderAndTakeColumnsInAnyOrder) {
  for (const char* text :
       {"Car,4,2,1.5", "Car;4;2;1.5\n", "Car 4 2 1.5", "# h l w class\n1.5 4 2 Car\n",
        "\xef\xbb\xbfw,h,l,class\n2,1.5,4,Car", "class;l;w;h\n\"Car\";4;2;1.5"}) {
    const auto sizes = parse_known_sizes(text, "t").sizes;
    ASSERT_EQ(sizes.size(), 1u) << text;
    EXPECT_EQ(sizes.at("Car")[0].size, Eigen::Vector3d(4, 2, 1.5)) << text;
  }
  EXPECT_EQ(parse_known_sizes("Car 4 2 1.5 Golf", "t").sizes.at("Car")[0].name, "Golf");
}

TEST(KnownSizes, WhatIsWrongIsToldWithItsPlace) {
  const auto refused = [](const char* text, std::vector<const char*> parts) {
    const std::string message = refusal<FormatError>([&] { parse_known_sizes(text, "fleet.csv"); });
    for (const char* part : parts) EXPECT_THAT(message, HasSubstr(part)) << text;
  };
  refused("", {"fleet.csv: expected rows", "none"});
  refused(" \n\n", {"fleet.csv: expected rows"});
  refused("class,l,w,h\n", {"fleet.csv: expected rows"});
  refused("Car,4,2\n", {"fleet.csv:1", "4 fields", "got 3"});
  refused("Car,4,2,1.5\nCar,4,2,1.5,Golf\n", {"fleet.csv:2", "4 fields", "got 5"});
  refused("class,l,w,h\nCar,4,0,1.5\n", {"fleet.csv:2", "w from 0.01 to 100 metres", "'0'"});
  refused("Car,-4,2,1.5", {"l from 0.01"});
  refused("Car,4280,1790,1490", {"l from 0.01 to 100 metres", "'4280'"});
  refused("Car,4,2,nan", {"a finite number as h"});
  refused("Car,4,2,inf", {"a finite number as h"});
  refused("Car,4,2,high", {"a finite number as h", "'high'"});
  refused(",4,2,1.5", {"name of a class"});
  refused("class,l,w,height\n", {"class, l, w, h, name", "'height'"});
  refused("class,l,w,l,h\n", {"'l' twice"});
  refused("class,l,w\n", {"none for 'h'"});
  refused("{\"Car\": [[4, 2, 1.5]]}", {"fleet.csv:1"});
  refused(
      "\x7f"
      "ELF\x01",
      {"fleet.csv:1"});
}

TEST(KnownSizes, FilesMustBeThere) {
  const TemporaryDirectory folder;
  EXPECT_THAT(refusal<IoError>([&] { read_known_sizes(folder / "none.csv"); }),
              HasSubstr("none.csv"));
  EXPECT_THROW(read_known_sizes(folder.path()), IoError);
  EXPECT_EQ(read_known_sizes(folder.write("a.csv", "Car 4 2 1")).sizes.size(), 1u);
}

}  // namespace
}  // namespace arbox::io

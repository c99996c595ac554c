#include "arbox/drawing/image.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "arbox/base/error.h"

namespace arbox::drawing {
namespace {

class ImageFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("arbox_image_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

Image two_colors() {
  Image image(5, 3, {10, 20, 30});
  image.pixels[0] = 250;
  return image;
}

TEST_F(ImageFile, PngComesBackWithEqualPixels) {
  const Image image = two_colors();
  write_image(image, folder_ / "a.PNG");
  const Image back = read_image(folder_ / "a.PNG");
  EXPECT_EQ(back.width, 5);
  EXPECT_EQ(back.height, 3);
  EXPECT_EQ(back.pixels, image.pixels);
}

TEST_F(ImageFile, JpegKeepsTheSize) {
  write_image(Image(32, 16, {200, 40, 40}), folder_ / "a.jpg");
  const Image back = read_image(folder_ / "a.jpg");
  EXPECT_EQ(back.width, 32);
  EXPECT_EQ(back.height, 16);
  EXPECT_NEAR(back.at(16, 8).r, 200, 4);
}

TEST_F(ImageFile, RefusesWhatIsNoImage) {
  std::ofstream(folder_ / "empty.png");
  std::ofstream(folder_ / "text.png") << "no picture";
  const std::string whole = encode_png(two_colors());
  std::ofstream(folder_ / "cut.png", std::ios::binary) << whole.substr(0, 20);
  EXPECT_THROW(read_image(folder_ / "empty.png"), FormatError);
  EXPECT_THROW(read_image(folder_ / "text.png"), FormatError);
  EXPECT_THROW(read_image(folder_ / "cut.png"), FormatError);
  EXPECT_THROW(read_image(folder_ / "missing.png"), IoError);
  EXPECT_THROW(read_image(folder_), IoError);
}

TEST_F(ImageFile, RefusesOtherExtensionsAndPlaces) {
  EXPECT_THROW(write_image(two_colors(), folder_ / "a.gif"), InvalidArgument);
  EXPECT_THROW(write_image(two_colors(), folder_ / "a"), InvalidArgument);
  EXPECT_THROW(write_image(Image(), folder_ / "a.png"), InvalidArgument);
  EXPECT_THROW(write_image(two_colors(), folder_ / "missing" / "a.png"), IoError);
}

TEST(Image, RefusesAbsurdSizes) {
  EXPECT_THROW(Image(0, 10, {}), InvalidArgument);
  EXPECT_THROW(Image(10, -1, {}), InvalidArgument);
  EXPECT_THROW(Image(1 << 20, 10, {}), InvalidArgument);
}

}  // namespace
}  // namespace arbox::drawing

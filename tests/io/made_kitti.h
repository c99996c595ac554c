#pragma once

#include <string>

#include "io/made_calibration.h"
#include "support/program.h"

/// \file
/// A small folder in KITTI's layout with made content.

namespace arbox::testing {

inline const std::string kMadeLabels =
    "Car 0.00 0 1.20 100.00 150.00 200.00 250.00 1.50 1.75 4.25 -2.50 1.75 20.00 1.10\n"
    "Cyclist 0.00 2 0.20 300.00 150.00 320.00 200.00 1.70 0.60 1.80 1.50 1.75 30.00 0.25\n"
    "DontCare -1 -1 -10 5.00 6.00 7.00 8.00 -1 -1 -1 -1000 -1000 -1000 -10\n";

inline const std::string kMadePlane = "# Matrix\nWIDTH 4\nHEIGHT 1\n0 -1 0 1.65\n";

/// The first 33 bytes of a PNG of 1242 x 375 pixels.
inline const std::string kMadePngHeader(
    "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x04\xda\0\0\x01\x77\x08\x02\0\0\0\xfc\x53\xb1\x8a", 33);

/// One point (1, 2, 3) of intensity 0.5.
inline const std::string kMadeScan("\0\0\x80\x3f\0\0\0\x40\0\0\x40\x40\0\0\0\x3f", 16);

/// Frames 000001, 000002 and 000003, whole but for the third's plane and image.
inline void make_kitti(const TemporaryDirectory& folder) {
  folder.write("ImageSets/train.txt", "000001\n000003\n");
  folder.write("ImageSets/val.txt", "000002\n");
  for (const std::string id : {"000001", "000002", "000003"}) {
    folder.write("training/velodyne/" + id + ".bin", kMadeScan);
    folder.write("training/label_2/" + id + ".txt", kMadeLabels);
    folder.write("training/calib/" + id + ".txt", kMadeCalibration);
    if (id == "000003") continue;
    folder.write("training/planes/" + id + ".txt", kMadePlane);
    folder.write("training/image_2/" + id + ".png", kMadePngHeader);
  }
}

}  // namespace arbox::testing

// consumer SCAN [MODEL]: a whole project that detects with an installed Arbox.
#include <arbox/detectors/open_detector.h>
#include <arbox/io/point_cloud_file.h>

#include <exception>
#include <iostream>

int main(int argc, char** argv) try {
  const auto scan = arbox::io::read_point_cloud(argc > 1 ? argv[1] : "scan.bin");
  const auto detector = arbox::detectors::open_detector(argc > 2 ? argv[2] : "cluster_fit");
  const auto result = detector->detect(scan.points.view(), {.quantiles = {0.2}, .score = 0.5});
  for (const auto& object : result.detections) {
    std::cout << object.label << ' ' << object.score << " at " << object.box.center.transpose()
              << ", a fifth of the draws hold " << object.quantile_boxes[0].box.size.transpose()
              << " m\n";
  }
} catch (const std::exception& error) {
  std::cerr << "consumer: " << error.what() << '\n';
  return 1;
}

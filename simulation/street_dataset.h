#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "arbox/simulation/camera_image.h"
#include "arbox/simulation/street_stream.h"

namespace arbox::simulation {

/// What is written of a street.
struct StreetDatasetOptions : StreetScanOptions {
  /// Pictures of the left colour camera too. Nothing else depends on it.
  bool images = false;
  CameraImageOptions image;

  StreetDatasetOptions() = default;
  /// Scans like these, without pictures.
  StreetDatasetOptions(const StreetScanOptions& scans) : StreetScanOptions(scans) {}

  template <class Visitor>
  static void describe(Visitor& visitor) {
    StreetScanOptions::describe(visitor);
    visitor.field("images", &StreetDatasetOptions::images,
                  {.help = "Write pictures of the left colour camera too"});
    visitor.group("image", &StreetDatasetOptions::image, "How these pictures are rendered");
  }
};

/// What a run of write_street_dataset did.
struct StreetDatasetReport {
  std::int64_t written = 0;
  /// Scenes that a run before had finished.
  std::int64_t found = 0;
};

/// Writes `scenes` scans (1..1000000) in the KITTI object benchmark's layout:
///
///     OUTPUT/training/{velodyne,label_2,label_360,calib,planes}/000000.{bin,txt}
///     OUTPUT/ImageSets/{train,val,trainval}.txt
///     OUTPUT/training/image_2/000000.png      with options.images
///     OUTPUT/simulation.yaml                  seed and options
///
/// label_360 holds the objects that the left colour camera does not see; every second frame is in
/// the validation split. Scenes run side by side on `threads` threads (0: default_threads()), each
/// on one. Files appear whole or not at all, and a scene's scan last: a run that was stopped goes
/// on where it stood and ends with the same bytes. More scenes may be added later.
///
/// `progress` is called after each scene, from any thread. Throws InvalidArgument for a count out
/// of range, ConfigError for options out of range or if OUTPUT was begun with another seed or other
/// options, IoError.
StreetDatasetReport write_street_dataset(const StreetDatasetOptions& options, std::uint64_t seed,
                                         std::int64_t scenes, const std::filesystem::path& output,
                                         int threads = 0,
                                         const std::function<void()>& progress = {});

}  // namespace arbox::simulation

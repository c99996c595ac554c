#pragma once

#include "arbox/base/options.h"

namespace arbox::testing {

enum class Overlap { kIou, kIog };

struct MergeOptions {
  double threshold = 0.5;
  Overlap overlap = Overlap::kIou;
  std::optional<int> limit = std::nullopt;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("threshold", &MergeOptions::threshold,
                  {.help = "Overlap from which two boxes are one", .low = 0, .high = 1});
    visitor.field("overlap", &MergeOptions::overlap,
                  {.help = "Measure", .choices = {"iou", "iog"}});
    visitor.field("limit", &MergeOptions::limit, {.help = "Most boxes kept", .low = 1});
  }
};

/// One field of every type that options may have.
struct AllOptions {
  double voxel_size = 0.05;
  float score = 0.25F;
  int layers = 3;
  std::int64_t offset = -5;
  std::uint64_t seed = 18446744073709551615U;
  bool flip = false;
  std::string name = "car seat: \"A\"";
  std::string mode = "fast";
  std::vector<double> quantiles = {0.1, 0.9};
  std::vector<std::string> classes = {"Car", "null"};
  std::vector<bool> mask = {};
  std::array<double, 3> extent = {1, 2, 3};
  std::optional<std::string> note = std::nullopt;
  double reach = std::numeric_limits<double>::infinity();
  MergeOptions nms = {};

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("voxel_size", &AllOptions::voxel_size,
                  {.help = "Edge of a voxel", .unit = "m", .low = 0.001, .high = 10});
    visitor.field("score", &AllOptions::score, {.help = "Least score", .low = 0, .high = 1});
    visitor.field("layers", &AllOptions::layers, {.help = "Number of layers", .low = 1});
    visitor.field("offset", &AllOptions::offset, {.help = "Offset", .high = 0});
    visitor.field("seed", &AllOptions::seed, {.help = "Seed of a | b"});
    visitor.field("flip", &AllOptions::flip, {.help = "Mirror the scan"});
    visitor.field("name", &AllOptions::name, {.help = "Name"});
    visitor.field("mode", &AllOptions::mode, {.help = "Mode", .choices = {"fast", "exact"}});
    visitor.field("quantiles", &AllOptions::quantiles, {.help = "Levels", .low = 0, .high = 1});
    visitor.field("classes", &AllOptions::classes, {.help = "Classes"});
    visitor.field("mask", &AllOptions::mask, {.help = "Mask"});
    visitor.field("extent", &AllOptions::extent, {.help = "Extent", .unit = "m", .low = 0});
    visitor.field("note", &AllOptions::note, {.help = "Note"});
    visitor.field("reach", &AllOptions::reach, {.help = "Reach", .unit = "m", .low = 0});
    visitor.group("nms", &AllOptions::nms, "How overlapping boxes are merged");
  }
};

}  // namespace arbox::testing

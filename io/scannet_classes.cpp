#include <algorithm>

#include "arbox/io/scannet.h"

namespace arbox::io {
namespace {

constexpr std::array<ScanNetClass, 18> kClasses = {{{"cabinet", 3},
                                                    {"bed", 4},
                                                    {"chair", 5},
                                                    {"sofa", 6},
                                                    {"table", 7},
                                                    {"door", 8},
                                                    {"window", 9},
                                                    {"bookshelf", 10},
                                                    {"picture", 11},
                                                    {"counter", 12},
                                                    {"desk", 14},
                                                    {"curtain", 16},
                                                    {"refrigerator", 24},
                                                    {"showercurtrain", 28},
                                                    {"toilet", 33},
                                                    {"sink", 34},
                                                    {"bathtub", 36},
                                                    {"garbagebin", 39}}};

// The ids that are no class of the benchmark, too; 39 is NYU40's "otherfurniture", which ScanNet's
// benchmark calls garbagebin.
constexpr std::array<std::string_view, 40> kNyu40 = {
    "wall",    "floor",      "cabinet",        "bed",          "chair",
    "sofa",    "table",      "door",           "window",       "bookshelf",
    "picture", "counter",    "blinds",         "desk",         "shelves",
    "curtain", "dresser",    "pillow",         "mirror",       "floormat",
    "clothes", "ceiling",    "books",          "refrigerator", "television",
    "paper",   "towel",      "showercurtrain", "box",          "whiteboard",
    "person",  "nightstand", "toilet",         "sink",         "lamp",
    "bathtub", "bag",        "otherstructure", "garbagebin",   "otherprop"};

}  // namespace

std::span<const ScanNetClass> scannet_classes() { return kClasses; }

std::vector<std::string> scannet_class_names() {
  std::vector<std::string> names;
  for (const ScanNetClass& one : kClasses) names.emplace_back(one.name);
  return names;
}

int nyu40_id(std::string_view name) {
  const auto found = std::find(kNyu40.begin(), kNyu40.end(), name);
  return found == kNyu40.end() ? 0 : static_cast<int>(found - kNyu40.begin()) + 1;
}

std::string_view nyu40_name(int id) {
  if (id < 1 || id > static_cast<int>(kNyu40.size())) return {};
  return kNyu40[static_cast<std::size_t>(id - 1)];
}

}  // namespace arbox::io

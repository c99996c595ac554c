#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/geometry/rotation.h"
#include "arbox/io/labeled_scene.h"

/// \file
/// Scenes of made boxes with points in them, for tests of readers and writers.

namespace arbox::testing {

enum class MadeBoxes { kAny, kUpright, kAxisAligned };

/// Six objects, classes in turn, each with 40 points in it; a colour of 0..255 and an intensity for
/// each point. The first box lies apart from the others.
inline io::LabeledScene made_scene(const std::string& name, std::uint64_t seed,
                                   io::SceneFrame frame, const std::vector<std::string>& classes,
                                   MadeBoxes boxes) {
  const RandomStream random(seed, 0, 0);
  std::uint32_t draw = 0;
  const auto between = [&](double low, double high) { return random.uniform(draw++, low, high); };
  io::LabeledScene scene{.name = name, .frame = frame};
  scene.cloud.channels = {"r", "g", "b"};
  for (std::size_t i = 0; i < 6; ++i) {
    geometry::Box box{
        .center = {8.0 + 3.0 * static_cast<double>(i), between(-4, 4), between(-1, 1)},
        .size = {between(0.5, 2), between(0.5, 2), between(0.5, 2)}};
    if (boxes != MadeBoxes::kAxisAligned) {
      box = geometry::make_yaw_box(box.center, box.size, between(-3, 3));
    }
    if (boxes == MadeBoxes::kAny) {
      box.rotation = geometry::to_quaternion(
          geometry::ZyzAngles{between(0, 6), between(0.2, 3), between(0, 6)});
    }
    scene.objects.push_back({.label = classes[i % classes.size()],
                             .box = box,
                             .heading = boxes == MadeBoxes::kAxisAligned ? io::Heading::kUnknown
                                                                         : io::Heading::kKnown});
    for (int p = 0; p < 40; ++p) {
      const Eigen::Vector3d inside(between(-0.5, 0.5), between(-0.5, 0.5), between(-0.5, 0.5));
      const Eigen::Vector3f point =
          (box.center + box.rotation * inside.cwiseProduct(box.size).eval()).cast<float>();
      scene.cloud.values.insert(scene.cloud.values.end(), point.data(), point.data() + 3);
      for (int c = 0; c < 3; ++c) {
        scene.cloud.values.push_back(static_cast<float>((p * (c + 5)) % 256) / 255.0F);
      }
      scene.point_objects.push_back(static_cast<std::int32_t>(i));
    }
  }
  return scene;
}

/// Boxes are equal up to the renamings of axes that their headings leave open.
inline void expect_same_objects(const io::LabeledScene& read, const io::LabeledScene& written,
                                double tolerance) {
  ASSERT_EQ(read.objects.size(), written.objects.size());
  for (std::size_t i = 0; i < read.objects.size(); ++i) {
    const io::LabeledObject& expected = written.objects[i];
    geometry::Box box = read.objects[i].box;
    if (read.objects[i].heading == io::Heading::kUnknown) {
      box = geometry::nearest_equivalent(box, expected.box.rotation);
    }
    EXPECT_EQ(read.objects[i].label, expected.label);
    EXPECT_LE((box.center - expected.box.center).norm(), tolerance) << i;
    EXPECT_LE((box.size - expected.box.size).norm(), tolerance) << i;
    EXPECT_LE(geometry::rotation_distance(box.rotation, expected.box.rotation),
              std::max(tolerance, 1e-7))
        << i;
  }
}

/// The points, in their order; the channels of the one that was read, where both have them.
inline void expect_same_cloud(const io::LabeledScene& read, const io::LabeledScene& written) {
  const auto first = read.cloud.view(), second = written.cloud.view();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    ASSERT_LE((first.position(i) - second.position(i)).norm(), 1e-5F) << i;
    for (const auto& channel : first.channels()) {
      const auto* other = second.find(channel.name);
      if (other == nullptr) continue;
      ASSERT_NEAR(first.value(channel, i), second.value(*other, i), 1e-6) << channel.name;
    }
  }
}

}  // namespace arbox::testing

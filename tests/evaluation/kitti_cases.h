#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/evaluation/kitti_protocol.h"

/// \file
/// Made objects in the numbers of KITTI label and result files.

namespace arbox::testing {

/// A car of 4 x 1.6 x 1.5 m that is easy to see, `place` metres ahead of the camera.
inline io::KittiObject made_object(const std::string& type = "Car", double place = 20.0) {
  io::KittiObject object;
  object.type = type;
  object.truncation = 0.0;
  object.occlusion = 0;
  object.alpha = 0.3;
  object.left = 100.0;
  object.top = 150.0;
  object.right = 200.0;
  object.bottom = 210.0;
  object.height = 1.5;
  object.width = 1.6;
  object.length = 4.0;
  object.x = 1.0;
  object.y = 1.7;
  object.z = place;
  object.rotation_y = 0.4;
  return object;
}

/// The object as a detector would report it when it is right.
inline io::KittiObject found(io::KittiObject object, double score) {
  object.truncation = -1.0;
  object.occlusion = -1;
  object.score = score;
  return object;
}

/// A prediction far from everything, in space and in the image.
inline io::KittiObject false_alarm(double score) {
  io::KittiObject object = found(made_object("Car", 60.0), score);
  object.left += 600.0;
  object.right += 600.0;
  return object;
}

/// 40 frames with one car each, found with the scores 0.99, 0.98, ...: recall rises by 1/40 a
/// frame, so the curve's points 0..39 are the precisions after 1..40 finds and point 40 is never
/// reached.
inline std::vector<evaluation::KittiFrame> forty_frames() {
  std::vector<evaluation::KittiFrame> frames;
  for (int i = 0; i < 40; ++i) {
    const io::KittiObject car = made_object();
    frames.push_back({.labels = {car}, .predictions = {found(car, 0.99 - 0.01 * i)}});
  }
  return frames;
}

/// Frames of many objects with found, missed, doubled and invented ones of three classes.
inline std::vector<evaluation::KittiFrame> random_frames(int count) {
  std::vector<evaluation::KittiFrame> frames;
  const char* const types[] = {"Car", "Pedestrian", "Cyclist", "Van", "DontCare"};
  for (int f = 0; f < count; ++f) {
    const RandomStream stream(21, static_cast<std::uint64_t>(f), 0);
    evaluation::KittiFrame frame;
    const std::uint32_t objects = stream.below(0, 12);
    for (std::uint32_t i = 0; i < objects; ++i) {
      const std::uint32_t draw = 1 + 20 * i;
      io::KittiObject label = made_object(types[stream.below(draw, 5)], 6.0 + 5.0 * i);
      label.left = stream.uniform(draw + 1, 0.0, 1000.0);
      label.right = label.left + stream.uniform(draw + 2, 20.0, 120.0);
      label.bottom = label.top + stream.uniform(draw + 3, 20.0, 80.0);
      label.occlusion = static_cast<int>(stream.below(draw + 4, 4));
      label.truncation = stream.uniform(draw + 5, 0.0, 0.6);
      frame.labels.push_back(label);
      if (label.type == "DontCare" && stream.below(draw + 6, 2)) continue;
      io::KittiObject near = found(label, stream.uniform(draw + 7));
      if (near.type == "DontCare") near.type = "Car";
      near.x += 0.1 * stream.normal(draw + 8);
      near.z += 0.1 * stream.normal(draw + 9);
      near.left += 5.0 * stream.normal(draw + 10);
      near.length *= std::exp(0.1 * stream.normal(draw + 11));
      near.alpha += stream.normal(draw + 12);
      if (stream.below(draw + 13, 5)) frame.predictions.push_back(near);
      if (stream.below(draw + 14, 4) == 0) {
        near.score *= 0.5;
        near.z += 0.2;
        frame.predictions.push_back(near);
      }
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace arbox::testing

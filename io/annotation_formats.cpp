#include <array>

#include "arbox/geometry/rotation.h"
#include "arbox/io/annotation_tools.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/json.h"

// What annotation tools read, written.

namespace arbox::io {
namespace {

/// Low or high along length, width and height, in labelCloud's order of vertices.
constexpr std::array<std::array<int, 3>, 8> kVertexSigns = {{{-1, -1, -1},
                                                             {-1, 1, -1},
                                                             {1, 1, -1},
                                                             {1, -1, -1},
                                                             {-1, -1, 1},
                                                             {-1, 1, 1},
                                                             {1, 1, 1},
                                                             {1, -1, 1}}};

std::string escaped(std::string_view text) {
  std::string result;
  for (const char letter : text) {
    if (letter == '&') {
      result += "&amp;";
    } else if (letter == '<') {
      result += "&lt;";
    } else if (letter == '>') {
      result += "&gt;";
    } else {
      result += letter;
    }
  }
  return result;
}

void append_element(std::string& text, const char* name, double value) {
  text.append("<").append(name).append(">");
  internal::append_number(text, value);
  text.append("</").append(name).append(">");
}

void append_track(std::string& text, std::int64_t frame, const LabeledObject& object) {
  const geometry::Box& box = object.box;
  const geometry::RollPitchYaw turn = geometry::roll_pitch_yaw(box.rotation);
  text += "    <item>\n      <objectType>" + escaped(object.label) + "</objectType>";
  append_element(text, "h", box.size.y());
  append_element(text, "w", box.size.x());
  append_element(text, "l", box.size.z());
  text += "<first_frame>" + std::to_string(frame) +
          "</first_frame>\n      <poses><count>1</count><item_version>2</item_version><item>";
  append_element(text, "tx", box.center.x());
  append_element(text, "ty", box.center.y());
  append_element(text, "tz", box.center.z());
  append_element(text, "rx", turn.roll);
  append_element(text, "ry", turn.pitch);
  append_element(text, "rz", turn.yaw);
  text +=
      "<state>2</state><occlusion>0</occlusion><occlusion_kf>0</occlusion_kf>"
      "<truncation>0</truncation><amt_occlusion>-1</amt_occlusion>"
      "<amt_occlusion_kf>-1</amt_occlusion_kf><amt_border_l>-1</amt_border_l>"
      "<amt_border_r>-1</amt_border_r><amt_border_kf>-1</amt_border_kf></item></poses>\n"
      "      <finished>1</finished>\n    </item>\n";
}

}  // namespace

std::string format_labelcloud_vertices(std::span<const LabeledObject> objects,
                                       std::string_view cloud) {
  Json list = Json::array();
  for (const LabeledObject& object : objects) {
    const geometry::Box& box = object.box;
    geometry::require_valid(box, "format_labelcloud_vertices");
    Json vertices = Json::array();
    for (const auto& sign : kVertexSigns) {
      const Eigen::Vector3d half =
          0.5 *
          Eigen::Vector3d(sign[0] * box.size.x(), sign[1] * box.size.y(), sign[2] * box.size.z());
      const Eigen::Vector3d vertex = box.center + box.rotation * half;
      vertices.push_back({vertex.x(), vertex.y(), vertex.z()});
    }
    list.push_back({{"name", object.label}, {"vertices", std::move(vertices)}});
  }
  const std::string name(cloud);
  return dump_json({{"folder", "pointclouds"},
                    {"filename", name},
                    {"path", "pointclouds/" + name},
                    {"objects", std::move(list)}},
                   4) +
         "\n";
}

std::string format_labelcloud_classes(std::span<const std::string> classes) {
  constexpr std::array<const char*, 6> kColors = {"#FF8000", "#0080FF", "#20A020",
                                                  "#C02020", "#8040C0", "#808000"};
  Json list = Json::array();
  for (std::size_t i = 0; i < classes.size(); ++i) {
    list.push_back({{"name", classes[i]}, {"id", i}, {"color", kColors[i % kColors.size()]}});
  }
  return dump_json({{"classes", std::move(list)},
                    {"default", 0},
                    {"type", "object_detection"},
                    {"format", "vertices"}},
                   4) +
         "\n";
}

std::string format_cvat_tracklets(const Tracklets& tracklets) {
  std::size_t count = 0;
  std::string items;
  for (const auto& [frame, objects] : tracklets) {
    for (const LabeledObject& object : objects) {
      geometry::require_valid(object.box, "format_cvat_tracklets");
      append_track(items, frame, object);
      ++count;
    }
  }
  return "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n"
         "<!DOCTYPE boost_serialization>\n"
         "<boost_serialization version=\"9\" signature=\"serialization::archive\">\n"
         "  <tracklets version=\"0\" tracking_level=\"0\" class_id=\"0\">\n    <count>" +
         std::to_string(count) + "</count>\n    <item_version>1</item_version>\n" + items +
         "  </tracklets>\n</boost_serialization>\n";
}

}  // namespace arbox::io

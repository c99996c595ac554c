#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string_view>

#include "arbox/base/error.h"
#include "arbox/evaluation/indoor_files.h"
#include "arbox/io/file.h"

namespace arbox::evaluation {
namespace {

constexpr std::size_t kCornerNumbers = 24;

using Corners = std::array<Eigen::Vector3d, 8>;

/// What came, short enough for a message.
std::string shown(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  return "'" + std::string(text.substr(0, kLongest)) + (text.size() > kLongest ? "...'" : "'");
}

class LineReader {
 public:
  LineReader(std::string_view source, std::size_t number, std::string_view line,
             const std::vector<std::string>& classes)
      : source_(source), number_(number), line_(line), classes_(classes) {}

  LabeledBox read(bool with_score) const {
    std::istringstream words{std::string(line_)};
    std::string label, corners, score, more;
    words >> label >> corners;
    LabeledBox result{.label = class_name(label), .box = box(corners), .score = 0.0};
    if (with_score) {
      if (!(words >> score)) fail("expected a score after the corners");
      result.score = number(score);
    }
    if (words >> more) fail("expected the end of the line, got " + shown(more));
    return result;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw FormatError(std::string(source_) + ":" + std::to_string(number_) + ": " + what);
  }

  double number(std::string_view text) const {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      fail("expected a finite number, got " + shown(text));
    }
    return value;
  }

  std::string class_name(const std::string& text) const {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (text.empty() || error != std::errc() || end != text.data() + text.size()) {
      fail("expected the number of a class, got " + shown(text));
    }
    if (classes_.empty()) return text;
    if (index >= classes_.size()) {
      fail("class " + text + " has no name; " + std::to_string(classes_.size()) +
           " class names were given");
    }
    return classes_[index];
  }

  Corners corners(std::string_view text) const {
    std::vector<double> values;
    while (true) {
      const std::size_t comma = text.find(',');
      values.push_back(number(text.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      text.remove_prefix(comma + 1);
    }
    if (values.size() != kCornerNumbers) {
      fail("expected 24 numbers of 8 corners, got " + std::to_string(values.size()));
    }
    Corners result;
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i] = {values[3 * i], values[3 * i + 2], -values[3 * i + 1]};
    }
    return result;
  }

  geometry::Box box(std::string_view text) const {
    const Corners corner = corners(text);
    const Eigen::Vector3d length = corner[1] - corner[2];
    const Eigen::Vector3d size(length.norm(), (corner[0] - corner[1]).norm(),
                               (corner[4] - corner[0]).norm());
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& one : corner) center += one / 8.0;
    if (!(size.array() > 0.0).all()) fail("the box has a size of zero");
    if (!size.allFinite() || !center.allFinite()) fail("the box is too large to be measured");
    const geometry::Box result =
        geometry::make_yaw_box(center, size, std::atan2(length.y(), length.x()));
    const double tolerance = 1e-4 * (1.0 + size.maxCoeff());
    for (const Eigen::Vector3d& own : geometry::corners(result)) {
      if (std::none_of(corner.begin(), corner.end(), [&](const Eigen::Vector3d& one) {
            return (one - own).norm() <= tolerance;
          })) {
        fail("the 8 corners are not those of an upright box");
      }
    }
    return result;
  }

  std::string_view source_;
  std::size_t number_;
  std::string_view line_;
  const std::vector<std::string>& classes_;
};

}  // namespace

std::vector<LabeledBox> parse_votenet_boxes(std::string_view text, std::string_view source,
                                            bool with_scores,
                                            const std::vector<std::string>& classes) {
  std::vector<LabeledBox> result;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    result.push_back(LineReader(source, number, line, classes).read(with_scores));
  }
  return result;
}

std::vector<LabeledBox> read_votenet_boxes(const std::filesystem::path& file, bool with_scores,
                                           const std::vector<std::string>& classes) {
  return parse_votenet_boxes(io::read_file(file), file.string(), with_scores, classes);
}

}  // namespace arbox::evaluation

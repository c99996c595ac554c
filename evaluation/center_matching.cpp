#include "arbox/evaluation/center_matching.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

#include "arbox/base/error.h"

namespace arbox::evaluation {
namespace {

void require_finite_boxes(std::span<const geometry::Detection> list, const char* what) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (std::isfinite(list[i].score) && list[i].box.center.allFinite()) continue;
    throw InvalidArgument("match_by_center: expected finite scores and centres, got others in " +
                          std::string(what) + " " + std::to_string(i));
  }
}

std::vector<std::size_t> best_score_first(std::span<const geometry::Detection> detections) {
  std::vector<std::size_t> order(detections.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return detections[a].score > detections[b].score;
  });
  return order;
}

}  // namespace

std::vector<CenterMatch> match_by_center(std::span<const geometry::Detection> detections,
                                         std::span<const geometry::Detection> objects,
                                         double max_distance) {
  if (!(max_distance > 0)) {
    throw InvalidArgument("match_by_center: expected a distance above 0, got " +
                          std::to_string(max_distance));
  }
  require_finite_boxes(detections, "detection");
  require_finite_boxes(objects, "object");
  std::vector<CenterMatch> matches;
  std::vector<bool> taken(objects.size());
  for (const std::size_t d : best_score_first(detections)) {
    std::optional<std::size_t> nearest;
    double least = max_distance;
    for (std::size_t o = 0; o < objects.size(); ++o) {
      if (taken[o] || objects[o].label != detections[d].label) continue;
      const double distance = (objects[o].box.center - detections[d].box.center).norm();
      if (nearest ? distance >= least : distance > least) continue;
      nearest = o;
      least = distance;
    }
    if (!nearest) continue;
    taken[*nearest] = true;
    matches.push_back({d, *nearest});
  }
  return matches;
}

}  // namespace arbox::evaluation

#include "arbox/simulation/internal/street_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "arbox/simulation/internal/object_sizes.h"

namespace arbox::simulation {
namespace {

Eigen::Affine3d pose_of(const Eigen::Vector3d& center, double yaw, const Eigen::Vector3d& scale) {
  Eigen::Affine3d pose = Eigen::Affine3d::Identity();
  pose.translate(center).rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())).scale(scale);
  return pose;
}

/// The shape whose proportions need the least stretching.
std::pair<ModelKind, int> nearest_shape(std::span<const ModelKind> kinds,
                                        const Eigen::Vector3d& size, Dice& dice) {
  std::pair<ModelKind, int> best{kinds.front(), 0};
  double least = std::numeric_limits<double>::infinity();
  for (const ModelKind kind : kinds) {
    for (int variant = 0; variant < variant_count(kind); ++variant) {
      const Eigen::Vector3d ratio = size.cwiseQuotient(model(kind, variant).size);
      const double stretch = ratio.array().log().abs().sum() + dice.uniform(0, 0.12);
      if (stretch < least) {
        least = stretch;
        best = {kind, variant};
      }
    }
  }
  return best;
}

std::vector<ModelKind> kinds_of(const std::string& label) {
  using enum ModelKind;
  if (label == "Car") return {kSmallCar, kHatchback, kSedan, kEstate, kSuv, kMinivan};
  if (label == "Van") return {kPanelVan, kMinibus};
  if (label == "Truck") return {kBoxTruck, kArticulatedTruck};
  if (label == "Tram") return {kTram};
  if (label == "Pedestrian") return {kPedestrian};
  if (label == "Cyclist") return {kCyclist};
  if (label == "Person_sitting") return {kPersonSitting};
  return {kTrailer};
}

}  // namespace

StreetBuilder::StreetBuilder(const Road& road, Dice& dice, Scene& scene)
    : road_(road), dice_(dice), scene_(scene) {
  taken_.push_back({.center = {-0.3, 0.0}, .half = {2.9, 1.15}, .yaw = 0.0});
}

bool StreetBuilder::overlap(const Footprint& a, const Footprint& b, double margin) {
  const Eigen::Vector2d apart = b.center - a.center;
  if (apart.norm() > a.half.norm() + b.half.norm() + margin) return false;
  for (const double yaw : {a.yaw, b.yaw}) {
    for (const Eigen::Vector2d& axis : {Eigen::Vector2d(std::cos(yaw), std::sin(yaw)),
                                        Eigen::Vector2d(-std::sin(yaw), std::cos(yaw))}) {
      double reach = margin;
      for (const Footprint* one : {&a, &b}) {
        const Eigen::Vector2d x(std::cos(one->yaw), std::sin(one->yaw));
        reach += one->half.x() * std::abs(axis.dot(x)) +
                 one->half.y() * std::abs(axis.dot(Eigen::Vector2d(-x.y(), x.x())));
      }
      if (std::abs(axis.dot(apart)) > reach) return false;
    }
  }
  return true;
}

bool StreetBuilder::claim(const Footprint& footprint, double margin) {
  for (const Footprint& other : taken_) {
    if (overlap(footprint, other, margin)) return false;
  }
  taken_.push_back(footprint);
  return true;
}

bool StreetBuilder::add_object(const std::string& label, ModelKind kind, int variant,
                               const Eigen::Vector3d& size, const Spot& spot, double speed,
                               double brightness) {
  const Eigen::Vector2d place = road_.position(spot.s, spot.t);
  const double yaw = geometry::wrap_angle(road_.heading(spot.s) + spot.turn);
  if (!claim({.center = place, .half = 0.5 * size.head<2>(), .yaw = yaw}, 0.15)) return false;
  double ground = 0.0;
  const Eigen::Vector2d ahead =
      0.35 * size.x() * Eigen::Vector2d(std::cos(spot.turn), std::sin(spot.turn));
  for (const double part : {-1.0, 0.0, 1.0}) {
    ground += road_.height(spot.s + part * ahead.x(), spot.t + part * ahead.y()) / 3.0;
  }
  const Eigen::Vector3d center(place.x(), place.y(), ground + 0.5 * size.z());
  const Model& shape = model(kind, variant);
  scene_.instances.push_back({.mesh = shape.mesh,
                              .pose = pose_of(center, yaw, size.cwiseQuotient(shape.size)),
                              .object = static_cast<std::int32_t>(scene_.objects.size()),
                              .brightness = brightness});
  scene_.objects.push_back({.label = label,
                            .box = geometry::make_yaw_box(center, size, yaw),
                            .velocity = speed * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0)});
  return true;
}

bool StreetBuilder::add_vehicle(const std::string& label, const Spot& spot, double speed) {
  const Eigen::Vector3d size = draw_size(label, dice_);
  const auto [kind, variant] = nearest_shape(kinds_of(label), size, dice_);
  const double paint = label == "Car" ? dice_.normal(-0.6, 0.6) : dice_.normal(-0.25, 0.5);
  return add_object(label, kind, variant, size, spot, speed,
                    std::clamp(std::exp(paint), 0.06, 2.0));
}

bool StreetBuilder::add_person(const std::string& label, const Spot& spot, double speed) {
  const Eigen::Vector3d size = draw_size(label, dice_);
  const auto [kind, variant] = nearest_shape(kinds_of(label), size, dice_);
  return add_object(label, kind, variant, size, spot, speed,
                    std::clamp<double>(std::exp(dice_.normal(-0.05, 0.3)), 0.3, 1.7));
}

bool StreetBuilder::add_thing(ModelKind kind, const Spot& spot, const Eigen::Vector3d& scale,
                              bool needs_room, double sink) {
  const Model& shape = model(kind, dice_.below(variant_count(kind)));
  const Eigen::Vector3d size = shape.size.cwiseProduct(scale);
  const Eigen::Vector2d place = road_.position(spot.s, spot.t);
  const double yaw = road_.heading(spot.s) + spot.turn;
  const double reach = kind == ModelKind::kBroadTree ? 0.15
                       : kind >= ModelKind::kHouse   ? 0.46
                                                     : 0.5;
  if (needs_room && !claim({.center = place, .half = reach * size.head<2>(), .yaw = yaw}, 0.05)) {
    return false;
  }
  const Eigen::Vector3d center(place.x(), place.y(),
                               road_.height(spot.s, spot.t) - sink + 0.5 * size.z());
  scene_.instances.push_back({.mesh = shape.mesh,
                              .pose = pose_of(center, yaw, scale),
                              .object = -1,
                              .brightness = std::clamp<double>(dice_.normal(1.0, 0.18), 0.5, 1.5)});
  return true;
}

}  // namespace arbox::simulation

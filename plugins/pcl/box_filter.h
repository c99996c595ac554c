#pragma once

#include <pcl/common/point_tests.h>
#include <pcl/filters/filter_indices.h>
// Point types of users have no instance in PCL's libraries.
#include <pcl/filters/impl/filter.hpp>
#include <pcl/filters/impl/filter_indices.hpp>

#include <utility>
#include <vector>

#include "arbox/plugins/pcl/box_detector.h"

namespace arbox::pcl {

/// Keeps the points that lie in boxes, or removes them with setNegative(true), as pcl::CropBox does
/// for one box:
///
///     arbox::pcl::BoxFilter<pcl::PointXYZI> filter;
///     filter.setInputCloud(cloud);
///     filter.setDetections(detections, 0.95);  // in boxes that hold the object with p = 0.95
///     filter.setNegative(true);
///     filter.filter(without_objects);
///
/// Points that are not finite lie nowhere: they are removed either way, and not listed among
/// getRemovedIndices(). setKeepOrganized() works as in every pcl::FilterIndices.
template <class PointT>
class BoxFilter : public ::pcl::FilterIndices<PointT> {
 public:
  using Ptr = ::pcl::shared_ptr<BoxFilter<PointT>>;
  using ConstPtr = ::pcl::shared_ptr<const BoxFilter<PointT>>;

  explicit BoxFilter(bool extract_removed_indices = false)
      : ::pcl::FilterIndices<PointT>(extract_removed_indices) {
    this->filter_name_ = "arbox::pcl::BoxFilter";
  }

  void setBoxes(std::vector<geometry::Box> boxes) { boxes_ = std::move(boxes); }
  /// The most likely boxes.
  void setDetections(const std::vector<geometry::Detection>& detections) {
    boxes_ = boxes_of(detections);
  }
  /// The boxes that hold the object with probability p (confidence_boxes_of).
  void setDetections(const std::vector<geometry::Detection>& detections, double p) {
    boxes_ = confidence_boxes_of(detections, p);
  }
  const std::vector<geometry::Box>& getBoxes() const { return boxes_; }

 protected:
  void applyFilter(::pcl::Indices& indices) override {
    std::vector<bool> inside(this->input_->size(), false);
    const auto objects =
        points_in_boxes(BoxDetector<PointT>::view_of(*this->input_), boxes_, this->indices_.get());
    for (const auto& object : objects) {
      for (const auto index : object.indices) inside[static_cast<std::size_t>(index)] = true;
    }
    indices.clear();
    this->removed_indices_->clear();
    for (const auto index : *this->indices_) {
      if (!::pcl::isFinite((*this->input_)[static_cast<std::size_t>(index)])) continue;
      if (inside[static_cast<std::size_t>(index)] != this->negative_) {
        indices.push_back(index);
      } else if (this->extract_removed_indices_) {
        this->removed_indices_->push_back(index);
      }
    }
  }

 private:
  std::vector<geometry::Box> boxes_;
};

extern template class BoxFilter<::pcl::PointXYZ>;
extern template class BoxFilter<::pcl::PointXYZI>;
extern template class BoxFilter<::pcl::PointXYZRGB>;
extern template class BoxFilter<::pcl::PointXYZRGBNormal>;

}  // namespace arbox::pcl

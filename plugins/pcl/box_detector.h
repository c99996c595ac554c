#pragma once

#include <pcl/common/io.h>
#include <pcl/pcl_base.h>
#include <pcl/point_types.h>
// Point types of users have no instance in PCL's libraries.
#include <pcl/impl/pcl_base.hpp>

#include <vector>

#include "arbox/base/error.h"
#include "arbox/plugins/pcl/detection_stage.h"

namespace arbox::pcl {

/// A detector as a stage of a PCL pipeline:
///
///     arbox::pcl::BoxDetector<pcl::PointXYZI> detector;
///     detector.setInputCloud(cloud);
///     detector.setModel("cluster_fit");
///     detector.setQuantile(0.1);
///     std::vector<arbox::geometry::Detection> detections;
///     detector.detect(detections);
///     std::vector<pcl::PointIndices> objects;
///     detector.segment(objects);
///
/// Takes every point type with registered x, y, z, organised or not, with points that are not
/// finite (they are left out and counted). The detector sees the type's further fields as channels
/// (detection_stage.h), as they are: `intensity` should be in 0..1 for models that use it. The
/// cloud is neither copied nor changed; with setIndices() the chosen points are brought together.
///
/// Coordinates and boxes: the cloud's frame, which detectors of streets take to be the LiDAR's (x
/// forward, y left, z up, sensor at the origin; a cloud's sensor pose is not applied). Not safe to
/// use from several threads at once.
template <class PointT>
class BoxDetector : public ::pcl::PCLBase<PointT>, public DetectionStage {
 public:
  using Ptr = ::pcl::shared_ptr<BoxDetector<PointT>>;
  using ConstPtr = ::pcl::shared_ptr<const BoxDetector<PointT>>;

  /// An empty cloud gives no detections. Throws InvalidArgument without a cloud, for indices out of
  /// range and requests that the detector refuses.
  void detect(std::vector<geometry::Detection>& detections) {
    detect();
    detections = getDetections();
  }

  /// The same; getDetections() has the result.
  void detect() {
    require_cloud();
    run(this->input_->points.data(), this->input_->size(), sizeof(PointT),
        ::pcl::getFields<PointT>(), chosen());
  }

  /// The cloud's points in the box of each object of the last detect(), in its order.
  void segment(std::vector<::pcl::PointIndices>& objects) const {
    segment(boxes_of(getDetections()), objects);
  }

  /// The cloud's points in each of the boxes, for example those of confidence_boxes_of().
  void segment(const std::vector<geometry::Box>& boxes,
               std::vector<::pcl::PointIndices>& objects) const {
    require_cloud();
    objects = points_in_boxes(view_of(*this->input_), boxes, chosen());
    for (::pcl::PointIndices& object : objects) object.header = this->input_->header;
  }

  /// The boxes of the last detect() as a mesh of thin bars.
  void getWireframes(::pcl::PolygonMesh& mesh) const { mesh = wireframe(getDetections()); }

  /// A cloud's points as Arbox sees them; the cloud must outlive the view.
  static geometry::PointCloudView view_of(const ::pcl::PointCloud<PointT>& cloud) {
    return pcl::view_of(cloud.points.data(), cloud.size(), sizeof(PointT),
                        ::pcl::getFields<PointT>());
  }

 private:
  void require_cloud() const {
    if (!this->input_) {
      throw InvalidArgument("BoxDetector: expected a cloud, call setInputCloud first");
    }
  }
  const ::pcl::Indices* chosen() const {
    return this->use_indices_ && this->indices_ ? this->indices_.get() : nullptr;
  }
};

extern template class BoxDetector<::pcl::PointXYZ>;
extern template class BoxDetector<::pcl::PointXYZI>;
extern template class BoxDetector<::pcl::PointXYZRGB>;
extern template class BoxDetector<::pcl::PointXYZRGBNormal>;

}  // namespace arbox::pcl

#pragma once

#include <pcl/PCLPointField.h>
#include <pcl/PointIndices.h>
#include <pcl/PolygonMesh.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "arbox/detectors/detector.h"
#include "arbox/geometry/detection.h"
#include "arbox/geometry/point_cloud_view.h"

/// \file
/// What the PCL stage does whatever the point type: box_detector.h and box_filter.h are thin
/// templates over it. Frames, units and boxes are those of docs/conventions.md.

namespace arbox::pcl {

/// The named numbers of a point type as channels of a view: every scalar field under its name but
/// x, y, z; a field of n > 1 scalars as name_0 .. name_{n-1}; rgb and rgba as bytes r, g, b. 64-bit
/// integers are left out. Throws InvalidArgument unless x, y, z are consecutive floats.
std::vector<geometry::Channel> channels_of(std::span<const ::pcl::PCLPointField> fields);

/// A view of points in a PCL cloud; nothing is copied.
geometry::PointCloudView view_of(const void* points, std::size_t count, std::size_t point_size,
                                 std::span<const ::pcl::PCLPointField> fields);

/// The detections' most likely boxes.
std::vector<geometry::Box> boxes_of(std::span<const geometry::Detection> detections);

/// For each detection the box that holds the object with probability p in (0, 1): the confidence
/// box that was asked for, else one made of its samples. Throws InvalidArgument for a detection
/// that has neither, and for p out of range.
std::vector<geometry::Box> confidence_boxes_of(std::span<const geometry::Detection> detections,
                                               double p);

/// The same for the quantile q in (0, 1): what more than q of the samples hold.
std::vector<geometry::Box> quantile_boxes_of(std::span<const geometry::Detection> detections,
                                             double q);

/// For each box the indices of the points in it, rising; non-finite points are in none. With
/// `among` only these points. O(points * boxes). Throws InvalidArgument for invalid boxes and
/// indices out of range.
std::vector<::pcl::PointIndices> points_in_boxes(const geometry::PointCloudView& cloud,
                                                 std::span<const geometry::Box> boxes,
                                                 const ::pcl::Indices* among = nullptr);

/// Boxes as a mesh that every viewer shows as a wireframe: thin bars along the edges and a heading
/// mark (io/wireframe.h), coloured by class (drawing's colours), or by `label` for plain boxes.
/// Throws InvalidArgument for invalid boxes.
::pcl::PolygonMesh wireframe(std::span<const geometry::Detection> detections);
::pcl::PolygonMesh wireframe(std::span<const geometry::Box> boxes, const std::string& label = "");

/// The settings and the work of a BoxDetector.
class DetectionStage {
 public:
  /// What detects: a detector ("cluster_fit", the default, or one of a plugin), a model's name or a
  /// .arbox file (detectors/open_detector.h). `options` are KEY=VALUE. Throws as open_detector.
  void setModel(const std::string& name, const std::vector<std::string>& options = {});
  /// A detector of the caller's.
  void setDetector(std::shared_ptr<const detectors::Detector> detector);

  /// Ask for the quantile box at q in (0, 1), or at several; replaces those asked for before.
  void setQuantile(double q) { request_.quantiles = {q}; }
  void setQuantiles(const std::vector<double>& qs) { request_.quantiles = qs; }
  /// Ask for boxes that hold the object with probability p in (0, 1).
  void setConfidence(double p) { request_.confidences = {p}; }
  void setConfidences(const std::vector<double>& ps) { request_.confidences = ps; }
  /// The sizes that objects of some classes may have (DetectionRequest::known_sizes).
  void setKnownSizes(const geometry::KnownSizes& sizes) { request_.known_sizes = sizes; }
  /// Leave out detections with a lower score (default 0.3).
  void setScoreThreshold(double score) { request_.score = score; }
  /// Keep the draws from each object's distribution (default no).
  void setKeepSamples(bool keep) { request_.samples = keep; }
  void setSeed(std::uint64_t seed) { request_.seed = seed; }
  /// 0, the default, means default_threads() (base/parallel.h).
  void setNumberOfThreads(int threads) { request_.threads = threads; }

  const detectors::DetectionRequest& getRequest() const { return request_; }
  /// Of the last detect(): best score first.
  const std::vector<geometry::Detection>& getDetections() const { return result_.detections; }
  /// Points that the last detect() left out because a coordinate was not finite.
  std::int64_t getDroppedPoints() const { return result_.dropped_points; }

 protected:
  ~DetectionStage() = default;
  /// Looks for objects in the points of a PCL cloud, or in those of `among`.
  void run(const void* points, std::size_t count, std::size_t point_size,
           std::span<const ::pcl::PCLPointField> fields, const ::pcl::Indices* among);

 private:
  std::shared_ptr<const detectors::Detector> detector_;
  detectors::DetectionRequest request_{.score = 0.3};
  detectors::DetectionResult result_;
};

}  // namespace arbox::pcl

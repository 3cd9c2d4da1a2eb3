// From camera clouds to one set of points, voxels and clusters. Two back ends give the same results.
#pragma once

#include "yarm/perception/types.hpp"

#include <memory>
#include <string>
#include <vector>

namespace yarm::perception {

/// Axial noise of a Kinect-like camera: sigma(z) = base + slope * (z - offset)^2, z = depth along the optical axis.
struct NoiseModel {
  float base{0.0012F};   ///< metres
  float slope{0.0019F};  ///< 1/metres
  float offset{0.4F};    ///< metres

  /// Standard deviation at a depth, metres.
  [[nodiscard]] float sigma(float depth) const {
    const float d = depth - offset;
    return base + slope * (d * d);
  }
};

/// Parameters of transforming, cropping and voxelising.
struct MergeParams {
  std::array<double, 3> voxel_size{0.1, 0.1, 0.1};  ///< edges of a voxel, metres; at most 2^26 voxels in the box
  std::array<double, 3> box_min{-2.5, -2.5, 0.01};  ///< lower limits of the box (inclusive), metres, world
  std::array<double, 3> box_max{2.5, 2.5, 1.3};     ///< upper limits of the box (inclusive), metres, world
  NoiseModel noise;                                 ///< of the cameras
  double floor_sigmas{4.0};    ///< a point must be above z = 0 by this many sigmas of its vertical noise; 0 = plain box
  double absurd_limit{100.0};  ///< a coordinate beyond this (or infinite) makes a point absurd: it is left out, metres
  double absurd_share{0.01};   ///< with a larger share of absurd points the whole cloud is left out
};

/// Parameters of Euclidean clustering of the voxels' centroids.
struct ClusterParams {
  double tolerance{0.2};  ///< centroids nearer than this are connected, metres
  int min_size{5};        ///< smallest cluster, voxels
  int max_size{25000};    ///< largest cluster, voxels
};

/// One way of doing the work. Keeps its buffers between calls: not thread safe, one instance a node.
class MergeBackend {
 public:
  virtual ~MergeBackend() = default;
  MergeBackend(const MergeBackend&) = delete;
  MergeBackend& operator=(const MergeBackend&) = delete;

  /// Transforms and crops the clouds of one set and voxelises the points: fills stamp, points, cameras, voxel_of_point,
  /// centroids and voxel_points of `out`, whose buffers are used again. Clouds may be empty or all NaN.
  virtual void merge(const std::vector<CameraCloud>& clouds, MergedSet& out) = 0;
  /// Voxelises `set.points` again, for a set that came as a message: the same result as merge gave.
  virtual void voxelise(MergedSet& set) = 0;
  /// Clusters the centroids: fills cluster_of_voxel and clusters.
  virtual void cluster(MergedSet& set) = 0;

 protected:
  MergeBackend() = default;
};

/// "fused": one pass over the points, dense voxel table, union-find. "pcl": PCL's transform, CropBox, VoxelGrid and
/// EuclideanClusterExtraction. Throws std::invalid_argument, naming every fault, on a bad name or bad parameters.
[[nodiscard]] std::unique_ptr<MergeBackend> makeBackend(const std::string& name, const MergeParams& merge,
                                                        const ClusterParams& cluster);

}  // namespace yarm::perception

#include "backends.hpp"
#include "crop_kernel.hpp"
#include "voxel_lattice.hpp"

#include <pcl/common/transforms.h>
#include <pcl/filters/crop_box.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace yarm::perception {

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Eigen::Vector4f corner(const std::array<double, 3>& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), 1.F};
}

/// The plain chain of PCL's own filters, one cloud after the other.
class PclBackend : public MergeBackend {
 public:
  PclBackend(const MergeParams& merge, const ClusterParams& cluster)
      : params_(merge), cluster_params_(cluster), lattice_(merge) {}

  void merge(const std::vector<CameraCloud>& clouds, MergedSet& out) override {
    out.stamp_ns = oldestStamp(clouds);
    out.points.clear();
    out.cameras.clear();
    out.absent.clear();
    for (std::size_t c = 0; c < clouds.size(); ++c) {
      out.cameras.push_back(addCloud(clouds[c], static_cast<int>(c), out.points));
    }
    voxelise(out);
  }

  void voxelise(MergedSet& set) override {
    const Cloud::Ptr cloud = toPcl(set.points);
    pcl::VoxelGrid<pcl::PointXYZ> grid;
    grid.setInputCloud(cloud);
    grid.setLeafSize(static_cast<float>(params_.voxel_size[0]), static_cast<float>(params_.voxel_size[1]),
                     static_cast<float>(params_.voxel_size[2]));
    Cloud voxels;
    if (!cloud->empty()) {
      grid.filter(voxels);
    }
    set.centroids.clear();
    for (const pcl::PointXYZ& p : voxels) {
      set.centroids.emplace_back(p.x, p.y, p.z);
    }
    indexVoxels(set);
  }

  void cluster(MergedSet& set) override {
    const Cloud::Ptr cloud(new Cloud);
    for (const Eigen::Vector3f& c : set.centroids) {
      cloud->emplace_back(c.x(), c.y(), c.z());
    }
    std::vector<pcl::PointIndices> found;
    if (!cloud->empty()) {
      const pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
      tree->setInputCloud(cloud);
      pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
      extraction.setClusterTolerance(cluster_params_.tolerance);
      extraction.setMinClusterSize(cluster_params_.min_size);
      extraction.setMaxClusterSize(cluster_params_.max_size);
      extraction.setSearchMethod(tree);
      extraction.setInputCloud(cloud);
      extraction.extract(found);
    }
    setClusters(found, set);
  }

 private:
  static Cloud::Ptr toPcl(const std::vector<MergedPoint>& points) {
    const Cloud::Ptr cloud(new Cloud);
    cloud->reserve(points.size());
    for (const MergedPoint& p : points) {
      cloud->emplace_back(p.x, p.y, p.z);
    }
    return cloud;
  }

  /// Absurd points are read as NaN.
  static CropCount readCloud(const CameraCloud& cloud, float limit, Cloud& out) {
    const std::size_t row_step = cloud.row_step == 0 ? cloud.width * cloud.point_step : cloud.row_step;
    out.resize(cloud.width * cloud.height);
    CropCount count;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::uint8_t* p = cloud.data + (i / cloud.width) * row_step + (i % cloud.width) * cloud.point_step;
      std::memcpy(&out[i].x, p + cloud.x_offset, sizeof(float));
      std::memcpy(&out[i].y, p + cloud.y_offset, sizeof(float));
      std::memcpy(&out[i].z, p + cloud.z_offset, sizeof(float));
      pcl::PointXYZ& point = out[i];
      if (std::fabs(point.x) > limit || std::fabs(point.y) > limit || std::fabs(point.z) > limit) {
        ++count.absurd;
        point.x = point.y = point.z = std::numeric_limits<float>::quiet_NaN();
      }
      count.finite += pcl::isFinite(point) ? 1U : 0U;
    }
    out.is_dense = false;
    return count;
  }

  CameraReport addCloud(const CameraCloud& cloud, int camera, std::vector<MergedPoint>& points) const {
    const Cloud::Ptr raw(new Cloud);
    CameraReport report = reportOf(cloud, readCloud(cloud, static_cast<float>(params_.absurd_limit), *raw), params_);
    if (report.dropped) {
      return report;
    }
    const Cloud::Ptr world(new Cloud);
    pcl::transformPointCloud(*raw, *world, cloud.T_world_camera.matrix());
    pcl::CropBox<pcl::PointXYZ> crop;
    crop.setInputCloud(world);
    crop.setMin(corner(params_.box_min));
    crop.setMax(corner(params_.box_max));
    pcl::Indices kept;
    crop.filter(kept);
    const CropSetup setup = makeCropSetup(params_, cloud.T_world_camera);
    const Eigen::Vector3f origin = cloud.T_world_camera.translation();
    for (const auto i : kept) {
      const pcl::PointXYZ& w = (*world)[static_cast<std::size_t>(i)];
      const float depth = (*raw)[static_cast<std::size_t>(i)].z;
      if (aboveFloorNoise(setup, depth, w.z)) {
        points.push_back(makeMergedPoint(params_.noise, origin, depth, w.x, w.y, w.z, camera));
        ++report.kept;
      }
    }
    return report;
  }

  /// Which voxel each point went to: PCL numbers the voxels in ascending order of their keys.
  void indexVoxels(MergedSet& set) {
    keys_.clear();
    for (const MergedPoint& p : set.points) {
      keys_.push_back(lattice_.keyOf(p));
    }
    sorted_ = keys_;
    std::sort(sorted_.begin(), sorted_.end());
    sorted_.erase(std::unique(sorted_.begin(), sorted_.end()), sorted_.end());
    set.voxel_of_point.resize(set.points.size());
    set.voxel_points.assign(sorted_.size(), 0);
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      const auto at = std::lower_bound(sorted_.begin(), sorted_.end(), keys_[i]) - sorted_.begin();
      set.voxel_of_point[i] = static_cast<std::int32_t>(at);
      ++set.voxel_points[static_cast<std::size_t>(at)];
    }
  }

  /// Puts PCL's clusters into the common order.
  static void setClusters(std::vector<pcl::PointIndices>& found, MergedSet& set) {
    for (pcl::PointIndices& c : found) {
      std::sort(c.indices.begin(), c.indices.end());
    }
    std::sort(found.begin(), found.end(), [](const pcl::PointIndices& a, const pcl::PointIndices& b) {
      return a.indices.size() != b.indices.size() ? a.indices.size() > b.indices.size() : a.indices[0] < b.indices[0];
    });
    set.cluster_of_voxel.assign(set.centroids.size(), -1);
    set.clusters.resize(found.size());
    for (std::size_t c = 0; c < found.size(); ++c) {
      set.clusters[c].assign(found[c].indices.begin(), found[c].indices.end());
      for (const auto v : found[c].indices) {
        set.cluster_of_voxel[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(c);
      }
    }
  }

  MergeParams params_;
  ClusterParams cluster_params_;
  VoxelLattice lattice_;
  std::vector<std::int32_t> keys_;
  std::vector<std::int32_t> sorted_;
};

}  // namespace

std::unique_ptr<MergeBackend> makePclBackend(const MergeParams& merge, const ClusterParams& cluster) {
  return std::make_unique<PclBackend>(merge, cluster);
}

}  // namespace yarm::perception

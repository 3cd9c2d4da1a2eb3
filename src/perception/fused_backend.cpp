#include "backends.hpp"
#include "crop_kernel.hpp"
#include "euclidean.hpp"
#include "voxel_lattice.hpp"

#include <algorithm>

namespace yarm::perception {

namespace {

class FusedBackend : public MergeBackend {
 public:
  FusedBackend(const MergeParams& merge, const ClusterParams& cluster)
      : params_(merge), cluster_params_(cluster), lattice_(merge), euclidean_(corner(merge.box_min), corner(merge.box_max),
                                                                            static_cast<float>(cluster.tolerance)) {
    table_.assign(static_cast<std::size_t>(lattice_.count()), -1);
  }

  void merge(const std::vector<CameraCloud>& clouds, MergedSet& out) override {
    out.stamp_ns = oldestStamp(clouds);
    out.points.clear();
    out.cameras.clear();
    for (std::size_t c = 0; c < clouds.size(); ++c) {
      out.cameras.push_back(addCloud(clouds[c], static_cast<int>(c), out.points));
    }
    voxelise(out);
  }

  void voxelise(MergedSet& set) override {
    number(set.points);
    set.centroids.assign(touched_.size(), Eigen::Vector3f::Zero());
    set.voxel_points.assign(touched_.size(), 0);
    set.voxel_of_point.resize(set.points.size());
    for (std::size_t i = 0; i < set.points.size(); ++i) {
      const auto voxel = static_cast<std::size_t>(table_[static_cast<std::size_t>(keys_[i])]);
      const MergedPoint& p = set.points[i];
      set.centroids[voxel] += Eigen::Vector3f(p.x, p.y, p.z);
      ++set.voxel_points[voxel];
      set.voxel_of_point[i] = static_cast<std::int32_t>(voxel);
    }
    for (std::size_t v = 0; v < touched_.size(); ++v) {
      set.centroids[v] /= static_cast<float>(set.voxel_points[v]);
      table_[static_cast<std::size_t>(touched_[v])] = -1;
    }
  }

  void cluster(MergedSet& set) override {
    const int count = euclidean_.label(set.centroids, labels_);
    clustersFromLabels(labels_, count, cluster_params_, set);
  }

 private:
  static Eigen::Vector3f corner(const std::array<double, 3>& p) {
    return Eigen::Vector3d(p[0], p[1], p[2]).cast<float>();
  }

  CameraReport addCloud(const CameraCloud& cloud, int camera, std::vector<MergedPoint>& points) {
    survivors_.clear();
    const CropSetup setup = makeCropSetup(params_, cloud.T_world_camera);
    CameraReport report{cloud.width * cloud.height, 0, false};
    report.absurd = !cropCloud(setup, cloud, survivors_);
    if (report.absurd) {
      return report;
    }
    report.kept = survivors_.size();
    const Eigen::Vector3f origin = cloud.T_world_camera.translation();
    for (const Survivor& s : survivors_) {
      points.push_back(makeMergedPoint(params_.noise, origin, s.depth, s.x, s.y, s.z, camera));
    }
    return report;
  }

  /// Writes the number of each occupied voxel, in ascending order of their keys, into the table.
  void number(const std::vector<MergedPoint>& points) {
    keys_.resize(points.size());
    touched_.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
      keys_[i] = lattice_.keyOf(points[i]);
      std::int32_t& slot = table_[static_cast<std::size_t>(keys_[i])];
      if (slot < 0) {
        slot = 0;
        touched_.push_back(keys_[i]);
      }
    }
    std::sort(touched_.begin(), touched_.end());
    for (std::size_t v = 0; v < touched_.size(); ++v) {
      table_[static_cast<std::size_t>(touched_[v])] = static_cast<std::int32_t>(v);
    }
  }

  MergeParams params_;
  ClusterParams cluster_params_;
  VoxelLattice lattice_;
  EuclideanClusters euclidean_;
  std::vector<Survivor> survivors_;
  std::vector<std::int32_t> table_;    // voxel key -> voxel index, -1 = empty
  std::vector<std::int32_t> keys_;     // key of each point
  std::vector<std::int32_t> touched_;  // occupied keys
  std::vector<std::int32_t> labels_;
};

}  // namespace

std::unique_ptr<MergeBackend> makeFusedBackend(const MergeParams& merge, const ClusterParams& cluster) {
  return std::make_unique<FusedBackend>(merge, cluster);
}

}  // namespace yarm::perception

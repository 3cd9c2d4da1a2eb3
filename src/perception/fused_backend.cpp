#include "backends.hpp"
#include "crop_kernel.hpp"
#include "euclidean.hpp"
#include "voxel_lattice.hpp"

namespace yarm::perception {

namespace {

class FusedBackend : public MergeBackend {
 public:
  FusedBackend(const MergeParams& merge, const ClusterParams& cluster)
      : params_(merge),
        cluster_params_(cluster),
        lattice_(merge),
        euclidean_(corner(merge.box_min), corner(merge.box_max), static_cast<float>(cluster.tolerance)) {
    const auto voxels = static_cast<std::size_t>(lattice_.count());
    table_.assign(voxels, 0);
    occupied_.assign(voxels / 64 + 1, 0);
  }

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
    number(set.points);
    set.centroids.assign(voxels_, Eigen::Vector3f::Zero());
    set.voxel_points.assign(voxels_, 0);
    set.voxel_of_point.resize(set.points.size());
    for (std::size_t i = 0; i < set.points.size(); ++i) {
      const auto voxel = static_cast<std::size_t>(table_[static_cast<std::size_t>(keys_[i])]);
      const MergedPoint& p = set.points[i];
      set.centroids[voxel] += Eigen::Vector3f(p.x, p.y, p.z);
      ++set.voxel_points[voxel];
      set.voxel_of_point[i] = static_cast<std::int32_t>(voxel);
    }
    for (std::size_t v = 0; v < voxels_; ++v) {
      set.centroids[v] /= static_cast<float>(set.voxel_points[v]);
    }
  }

  void cluster(MergedSet& set) override {
    const Components components = euclidean_.label(set.centroids);
    clustersFromLabels(components.of_point, components.count, cluster_params_, set);
  }

 private:
  static Eigen::Vector3f corner(const std::array<double, 3>& p) {
    return Eigen::Vector3d(p[0], p[1], p[2]).cast<float>();
  }

  CameraReport addCloud(const CameraCloud& cloud, int camera, std::vector<MergedPoint>& points) {
    survivors_.clear();
    const CropSetup setup = makeCropSetup(params_, cloud.T_world_camera);
    CameraReport report = reportOf(cloud, cropCloud(setup, cloud, survivors_), params_);
    if (report.dropped) {
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
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto key = static_cast<std::uint32_t>(lattice_.keyOf(points[i]));
      keys_[i] = static_cast<std::int32_t>(key);
      occupied_[key / 64] |= std::uint64_t{1} << (key % 64);
    }
    std::int32_t count = 0;
    for (std::size_t w = 0; w < occupied_.size(); ++w) {
      for (std::uint64_t word = occupied_[w]; word != 0; word &= word - 1) {
        table_[w * 64 + static_cast<std::size_t>(__builtin_ctzll(word))] = count++;
      }
      occupied_[w] = 0;
    }
    voxels_ = static_cast<std::size_t>(count);
  }

  MergeParams params_;
  ClusterParams cluster_params_;
  VoxelLattice lattice_;
  EuclideanClusters euclidean_;
  std::vector<Survivor> survivors_;
  std::vector<std::int32_t> table_;      // voxel key -> voxel index; only what the present set occupies is valid
  std::vector<std::uint64_t> occupied_;  // bit of each voxel key; all 0 between calls
  std::vector<std::int32_t> keys_;       // key of each point
  std::size_t voxels_{0};
};

}  // namespace

std::unique_ptr<MergeBackend> makeFusedBackend(const MergeParams& merge, const ClusterParams& cluster) {
  return std::make_unique<FusedBackend>(merge, cluster);
}

}  // namespace yarm::perception

#include "backends.hpp"

#include "voxel_lattice.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <sstream>
#include <stdexcept>

namespace yarm::perception {

namespace {

constexpr double kMostVoxels = 67108864.0;  // 2^26

void require(bool good, const std::string& fault, std::ostringstream& faults) {
  if (!good) {
    faults << (faults.tellp() > 0 ? "; " : "") << fault;
  }
}

std::string text(const char* name, double value, const char* accepted) {
  std::ostringstream out;
  out << name << " = " << value << " (" << accepted << ")";
  return out.str();
}

}  // namespace

void checkParams(const MergeParams& merge, const ClusterParams& cluster) {
  std::ostringstream faults;
  bool sizes_good = true;
  for (std::size_t a = 0; a < 3; ++a) {
    const double edge = merge.voxel_size[a];
    const bool good = edge >= 1e-4 && edge <= 10.0 && merge.box_min[a] < merge.box_max[a];
    sizes_good = sizes_good && good;
    require(edge >= 1e-4 && edge <= 10.0, text("voxel_size", edge, "1e-4 .. 10 m"), faults);
    require(merge.box_min[a] < merge.box_max[a], text("box_min", merge.box_min[a], "less than box_max"), faults);
  }
  if (sizes_good) {
    const double voxels = VoxelLattice(merge).count();
    require(voxels <= kMostVoxels, text("voxels in the box", voxels, "at most 2^26: larger voxels or a smaller box"),
            faults);
  }
  require(merge.floor_sigmas >= 0.0 && merge.floor_sigmas <= 100.0,
          text("floor_sigmas", merge.floor_sigmas, "0 .. 100"), faults);
  require(merge.absurd_limit > 0.0, text("absurd_limit", merge.absurd_limit, "above 0 m"), faults);
  require(merge.absurd_share >= 0.0 && merge.absurd_share <= 1.0, text("absurd_share", merge.absurd_share, "0 .. 1"),
          faults);
  require(cluster.tolerance >= 1e-3 && cluster.tolerance <= 10.0, text("tolerance", cluster.tolerance, "1e-3 .. 10 m"),
          faults);
  require(cluster.min_size >= 1, text("min_size", cluster.min_size, "1 or more"), faults);
  require(cluster.max_size >= cluster.min_size, text("max_size", cluster.max_size, "at least min_size"), faults);
  if (faults.tellp() > 0) {
    throw std::invalid_argument("merge parameters refused: " + faults.str());
  }
}

CameraReport reportOf(const CameraCloud& cloud, const CropCount& count, const MergeParams& params) {
  CameraReport report;
  report.points = cloud.width * cloud.height;
  report.absurd = count.absurd;
  report.dropped = static_cast<double>(count.absurd) > params.absurd_share * static_cast<double>(report.points);
  report.finite = report.dropped ? 0 : count.finite;
  return report;
}

StampNs oldestStamp(const std::vector<CameraCloud>& clouds) {
  StampNs oldest = clouds.empty() ? 0 : std::numeric_limits<StampNs>::max();
  for (const CameraCloud& cloud : clouds) {
    oldest = std::min(oldest, cloud.stamp_ns);
  }
  return oldest;
}

MergedPoint makeMergedPoint(const NoiseModel& noise, const Eigen::Vector3f& camera_origin, float depth, float x,
                            float y, float z, int camera) {
  const Eigen::Vector3f ray = Eigen::Vector3f(x, y, z) - camera_origin;
  const float length = ray.norm();
  // The model gives the noise of the depth; along the ray it is longer by length / depth.
  const float inverse = length > 0.F && depth > 0.F ? 1.F / (length * depth) : 0.F;
  const float scale = inverse * depth;
  const float sigma = noise.sigma(depth) * (length * length * inverse);
  return {x, y, z, sigma, ray.x() * scale, ray.y() * scale, ray.z() * scale, camera};
}

void clustersFromLabels(const std::vector<std::int32_t>& labels, int label_count, const ClusterParams& params,
                        MergedSet& set) {
  std::vector<std::int32_t> sizes(static_cast<std::size_t>(label_count), 0);
  for (const std::int32_t label : labels) {
    ++sizes[static_cast<std::size_t>(label)];
  }
  std::vector<std::int32_t> order;
  for (std::int32_t label = 0; label < label_count; ++label) {
    const std::int32_t size = sizes[static_cast<std::size_t>(label)];
    if (size >= params.min_size && size <= params.max_size) {
      order.push_back(label);
    }
  }
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return sizes[static_cast<std::size_t>(a)] > sizes[static_cast<std::size_t>(b)];
  });
  std::vector<std::int32_t> rank(static_cast<std::size_t>(label_count), -1);
  set.clusters.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    rank[static_cast<std::size_t>(order[i])] = static_cast<std::int32_t>(i);
    set.clusters[i].clear();
  }
  set.cluster_of_voxel.resize(labels.size());
  for (std::size_t v = 0; v < labels.size(); ++v) {
    const std::int32_t cluster = rank[static_cast<std::size_t>(labels[v])];
    set.cluster_of_voxel[v] = cluster;
    if (cluster >= 0) {
      set.clusters[static_cast<std::size_t>(cluster)].push_back(static_cast<std::int32_t>(v));
    }
  }
}

std::unique_ptr<MergeBackend> makeBackend(const std::string& name, const MergeParams& merge,
                                          const ClusterParams& cluster) {
  checkParams(merge, cluster);
  if (name == "fused") {
    return makeFusedBackend(merge, cluster);
  }
  if (name == "pcl") {
    return makePclBackend(merge, cluster);
  }
  throw std::invalid_argument("backend '" + name + "' is not known: fused or pcl");
}

}  // namespace yarm::perception

// Euclidean clustering by union-find over a coarse lattice: the same partition as PCL's EuclideanClusterExtraction.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace yarm::perception {

/// Connects points nearer than a tolerance. Buffers are kept between calls: not thread safe.
class EuclideanClusters {
 public:
  /// Lattice limits and tolerance, metres; points must lie within the limits.
  EuclideanClusters(const Eigen::Vector3f& min, const Eigen::Vector3f& max, float tolerance);

  /// Writes the label of each point's component (0, 1, ... in the order of first appearance) and returns their number.
  int label(const std::vector<Eigen::Vector3f>& points, std::vector<std::int32_t>& labels);

 private:
  std::int32_t find(std::int32_t node);
  void bin(const std::vector<Eigen::Vector3f>& points);
  [[nodiscard]] bool reaches(const std::vector<Eigen::Vector3f>& points, std::int32_t a, std::int32_t b) const;
  void joinAlong(const std::vector<Eigen::Vector3f>& points, const std::vector<std::int32_t>& offsets);

  Eigen::Vector3f min_;
  float inverse_edge_;
  float tolerance2_;
  int nx_, ny_, nz_;
  std::vector<std::int32_t> table_;   // bin of a lattice site, -1 = empty; a rim of two empty sites all around
  std::vector<std::int32_t> site_;    // lattice site of each occupied bin
  std::vector<std::int32_t> first_;   // first point of each occupied bin
  std::vector<std::int32_t> next_;    // next point in the same bin
  std::vector<std::int32_t> bin_of_;  // occupied bin of each point
  std::vector<std::int32_t> parent_;  // union-find over occupied bins
  std::vector<std::int32_t> root_;    // root of each bin when the present round of joining began
  std::vector<std::int32_t> near_;    // half of the direct neighbours
  std::vector<std::int32_t> far_;     // half of the next ring
};

}  // namespace yarm::perception

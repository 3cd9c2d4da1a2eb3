// Euclidean clustering by union-find (Galler and Fischer, 1964) over a coarse lattice: the same partition as PCL's
// EuclideanClusterExtraction.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace yarm::perception {

/// The connected component of each point, numbered 0, 1, ... in the order of first appearance.
struct Components {
  const std::vector<std::int32_t>& of_point;
  int count;
};

/// Connects points nearer than a tolerance. Buffers are kept between calls: not thread safe.
class EuclideanClusters {
 public:
  /// Lattice limits and tolerance, metres; points must lie within the limits.
  EuclideanClusters(const Eigen::Vector3f& min, const Eigen::Vector3f& max, float tolerance);

  /// The components of some points; valid until the next call.
  [[nodiscard]] Components label(const std::vector<Eigen::Vector3f>& points);

 private:
  std::int32_t find(std::int32_t node);
  void bin(const std::vector<Eigen::Vector3f>& points);
  [[nodiscard]] bool reaches(const std::vector<Eigen::Vector3f>& points, std::int32_t a, std::int32_t b) const;
  /// Some of five neighbouring sites in a row: bit k stands for the site `offset` + k away.
  struct Row {
    std::int32_t offset;
    std::uint32_t sites;
  };
  /// Those sites of a row, seen from a site, that hold points.
  [[nodiscard]] std::uint32_t taken(std::int32_t site, const Row& row) const;
  void joinAlong(const std::vector<Eigen::Vector3f>& points, const std::vector<Row>& rows);

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
  std::vector<std::uint64_t> taken_;  // a bit for each lattice site that holds points; all 0 between calls
  std::vector<std::int32_t> labels_;  // component of each point
  std::vector<Row> near_;             // half of the direct neighbours
  std::vector<Row> far_;              // half of the next ring
};

}  // namespace yarm::perception

// What a map and a trajectory are worth, against the truth.
#pragma once

#include "slam_world.hpp"
#include "yarm/slam/types.hpp"

#include <Eigen/Core>

#include <vector>

namespace yarm::test {

/// Points on the true surfaces, 2 cm apart, and in how many scans a beam ended near each.
class SeenSurfaces {
 public:
  explicit SeenSurfaces(const Arena& arena);

  /// Notes the ends of a moment's beams that lie within `most_range`, m.
  void add(const Moment& moment, double most_range);
  /// Points that at least this many scans have seen.
  [[nodiscard]] std::vector<Eigen::Vector2d> seen(int scans) const;

 private:
  const Arena& arena_;
  std::vector<int> first_of_surface_;
  std::vector<Eigen::Vector2d> points_;
  std::vector<int> scans_;  ///< that have seen each point
  std::vector<int> last_;   ///< the last of them
  int moments_{0};
};

/// A map against the true surfaces. Lengths in metres, shares 0 to 1.
struct MapScore {
  double mean{0};  ///< distance of occupied cells to the nearest true surface
  double p95{0};
  double most{0};
  double within_5cm{0};  ///< share of seen surface points with an occupied cell that near
  double within_10cm{0};
  double spurious{0};  ///< share of occupied cells farther than 0.10 m from every surface
  int occupied{0};
  slam::Pose2 T_arena_map;  ///< used for the comparison
};

/// Compares after moving the map's frame by `T_arena_map`, and, when asked, after the rigid fit that suits it best.
[[nodiscard]] MapScore scoreMap(const slam::GridMap& map, const Arena& arena, const std::vector<Eigen::Vector2d>& seen,
                                const slam::Pose2& T_arena_map, bool fit);

/// A trajectory against the truth, unaligned.
struct PoseScore {
  double rmse{0};          ///< m
  double p95{0};           ///< m
  double most{0};          ///< m
  double heading_rms{0};   ///< rad
  double heading_p95{0};   ///< rad
  double heading_most{0};  ///< rad
};

/// Collects poses one by one.
class PoseErrors {
 public:
  void add(const slam::Pose2& estimate, const slam::Pose2& truth);
  [[nodiscard]] PoseScore score() const;

 private:
  std::vector<double> off_, turned_;
};

}  // namespace yarm::test

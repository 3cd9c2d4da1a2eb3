// Least squares over poses that are tied by measured differences.
//
// The formulation is that of F. Lu and E. Milios, "Globally consistent range scan alignment for environment mapping",
// Autonomous Robots 4, 1997; errors, Jacobians and the sparse solution follow G. Grisetti, R. Kuemmerle, C. Stachniss
// and W. Burgard, "A tutorial on graph-based SLAM", IEEE Intelligent Transportation Systems Magazine 2(4), 2010.
#pragma once

#include "yarm/slam/params.hpp"
#include "yarm/slam/types.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace yarm::slam {

/// A measured difference between two poses.
struct PoseEdge {
  int from{0};
  int to{0};
  Pose2 T_from_to;
  Eigen::Matrix3d information{Eigen::Matrix3d::Identity()};  ///< x, y, yaw along the axes of `to`
  bool is_odometry{false};                                   ///< measured by the wheels, not by a match
};

/// Answer of an optimisation.
struct GraphResult {
  bool ok{false};
  std::string reason;        ///< why not ok; the poses are then those given
  std::vector<Pose2> poses;  ///< the first is held where it is
  double error_before{0};    ///< sum of the robust costs, squared sigmas
  double error_after{0};
  int iterations{0};
};

/// How far two poses are from what an edge measured, squared sigmas.
[[nodiscard]] double squaredErrorOf(const PoseEdge& edge, const Pose2& from, const Pose2& to);

/// Moves the poses to where the edges' robust (Cauchy) costs are least. Pose 0 stays. Every pose must be tied to it.
/// One sparse Cholesky factorisation an iteration.
[[nodiscard]] GraphResult optimize(const std::vector<Pose2>& poses, const std::vector<PoseEdge>& edges,
                                   const GraphParams& params);

}  // namespace yarm::slam

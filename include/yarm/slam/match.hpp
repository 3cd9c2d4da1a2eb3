// Matching one scan against others, point to line.
//
// Point-to-line distances and Gauss-Newton as in A. Censi, "An ICP variant using a point-to-line metric", ICRA 2008;
// the pairing of scans taken at different places goes back to F. Lu and E. Milios, "Robot pose estimation in unknown
// environments by matching 2D range scans", J. Intelligent and Robotic Systems 18, 1997. The agreement of normals keeps
// the two faces of a thin wall apart, and a point without a partner counts nothing: unseen space pulls nowhere.
#pragma once

#include "yarm/slam/params.hpp"
#include "yarm/slam/scan_points.hpp"
#include "yarm/slam/types.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace yarm::slam {

/// A scan with a known pose; the points must outlive the call it is handed to.
struct MatchTarget {
  const ScanPoints* points{nullptr};
  Pose2 T_map_sensor;
};

/// A Gaussian of a pose; information over (x, y, yaw) along the map's axes.
struct PosePrior {
  Pose2 pose;
  Eigen::Matrix3d information{Eigen::Matrix3d::Zero()};
};

/// Answer of a match.
struct MatchResult {
  bool ok{false};
  std::string reason;                                    ///< why not ok
  Pose2 T_map_sensor;                                    ///< the best pose; the start when no point found a partner
  Eigen::Matrix3d information{Eigen::Matrix3d::Zero()};  ///< of the points alone, x, y, yaw along the map's axes
  int in_view{0};                                        ///< points that at least one target should have seen
  int paired{0};                                         ///< of these, those with a partner
  double residual{0};  ///< root mean square of the pairs' distances to their lines, sigmas
  int iterations{0};

  /// Share of the points in view that have a partner.
  [[nodiscard]] double share() const { return in_view > 0 ? static_cast<double>(paired) / in_view : 0.0; }
};

/// Finds the pose of a scan among targets, from a start that is off by no more than about the first gate.
/// `prior` weighs in where the points leave a direction free; without it a weak pull towards the start does.
/// O(iterations x points x targets).
[[nodiscard]] MatchResult matchScan(const ScanPoints& scan, const Pose2& start, const std::vector<MatchTarget>& targets,
                                    const std::optional<PosePrior>& prior, const MatchParams& params);

/// Share of a scan's points (every fourth) that a target would have seen.
[[nodiscard]] double overlapOf(const ScanPoints& scan, const Pose2& T_map_sensor, const MatchTarget& target);

}  // namespace yarm::slam

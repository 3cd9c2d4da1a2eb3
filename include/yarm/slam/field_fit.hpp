// Fitting points to the surfaces of a known map.
#pragma once

#include "yarm/slam/distance_field.hpp"
#include "yarm/slam/localiser_params.hpp"
#include "yarm/slam/match.hpp"
#include "yarm/slam/types.hpp"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace yarm::slam {

/// A point seen, in the frame whose pose is sought.
struct SeenPoint {
  Eigen::Vector2d at{Eigen::Vector2d::Zero()};  ///< metres
  double sigma{0};                              ///< standard deviation, metres
};

/// Answer of a fit.
struct FitResult {
  Pose2 pose;                                            ///< map frame
  Eigen::Matrix3d information{Eigen::Matrix3d::Zero()};  ///< of the points alone, x, y, yaw along the map's axes
  int points{0};
  int agreeing{0};  ///< points within FitParams::gate_last of a surface

  /// Share of the points that agree with the map.
  [[nodiscard]] double share() const { return points > 0 ? static_cast<double>(agreeing) / points : 0.0; }
};

/// Moves a pose to where the points' distances to the nearest surfaces are least: Gauss-Newton with Cauchy weights and
/// a shrinking gate, a prior in the same equations. Points without a surface in the gate count nothing, so things that
/// the map does not know pull nowhere. O(iterations x points).
[[nodiscard]] FitResult fitToField(const std::vector<SeenPoint>& points, const Pose2& start, const DistanceField& field,
                                   const std::optional<PosePrior>& prior, const FitParams& params);

/// At most `most` beams of a scan as points in the robot's frame, evenly chosen among those that saw something.
[[nodiscard]] std::vector<SeenPoint> seenPoints(const Scan& scan, const ScanParams& params, int most);

}  // namespace yarm::slam

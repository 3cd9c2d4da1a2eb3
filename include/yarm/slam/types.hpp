// Data that goes into and comes out of the map maker. Plain structs, no ROS.
// Units: metres, radians; times are integer nanoseconds. Planar frames: x ahead, y left, yaw counter-clockwise.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace yarm::slam {

/// Places farther from the origin on an axis are refused, metres: cells are counted in whole numbers.
constexpr double kMostFar = 10000.0;

/// An angle brought into [-pi, pi].
[[nodiscard]] inline double wrapAngle(double angle) {
  return std::remainder(angle, 2.0 * M_PI);
}

/// A rigid motion of the plane; `T_a_b` takes points of frame b to frame a.
struct Pose2 {
  double x{0};    ///< metres
  double y{0};    ///< metres
  double yaw{0};  ///< radians, in [-pi, pi] after every operation

  /// T_a_c from T_a_b (this) and T_b_c.
  [[nodiscard]] Pose2 operator*(const Pose2& other) const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return {x + c * other.x - s * other.y, y + s * other.x + c * other.y, wrapAngle(yaw + other.yaw)};
  }
  /// A point of frame b in frame a.
  [[nodiscard]] Eigen::Vector2d operator*(const Eigen::Vector2d& point) const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return {x + c * point.x() - s * point.y(), y + s * point.x() + c * point.y()};
  }
  /// T_b_a.
  [[nodiscard]] Pose2 inverse() const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return {-c * x - s * y, s * x - c * y, wrapAngle(-yaw)};
  }
  [[nodiscard]] bool isFinite() const { return std::isfinite(x) && std::isfinite(y) && std::isfinite(yaw); }
  /// Distance between the origins, metres.
  [[nodiscard]] double distanceTo(const Pose2& other) const { return std::hypot(x - other.x, y - other.y); }
};

/// One planar scan with the odometry of its moment.
struct Scan {
  std::int64_t stamp_ns{0};   ///< capture time
  double angle_min{0};        ///< bearing of beam 0 in the sensor's frame, radians
  double angle_increment{0};  ///< from a beam to the next, radians; negative when beams run clockwise
  double range_min{0};        ///< shorter ranges count as nothing seen, metres
  double range_max{0};        ///< longer ranges count as nothing seen, metres
  std::vector<float> ranges;  ///< metres; anything not within the limits, NaN and infinities are nothing seen
  Pose2 T_base_sensor;        ///< where the sensor sits
  Pose2 T_odom_base;          ///< what odometry says at the capture time
};

/// What became of a scan.
enum class ScanStatus {
  kDropped,    ///< refused; the reason says why
  kPredicted,  ///< too little motion for a match: the pose is the last one moved on by odometry
  kMatched,    ///< matched in a known place, which needs no new keyframe
  kKeyframe,   ///< matched and kept as a keyframe
  kUnmatched,  ///< a match was due and failed, or the scan sees too little: odometry alone; the reason says why
};

/// Name of a status, for messages.
[[nodiscard]] const char* toString(ScanStatus status);

/// Answer to one scan.
struct ScanResult {
  ScanStatus status{ScanStatus::kDropped};
  std::string reason;  ///< filled for kDropped and kUnmatched
  Pose2 T_map_base;    ///< pose at the scan's time
  Pose2 T_map_odom;    ///< correction of the odometry's frame
  double entropy{0};   ///< differential entropy of the pose's Gaussian since the last match, nats
};

/// An occupancy grid, row-major, origin in the lower left corner.
struct GridMap {
  int width{0};                    ///< cells along x
  int height{0};                   ///< cells along y
  double resolution{0};            ///< edge of a cell, metres
  double origin_x{0};              ///< x of the lower left corner of cell (0, 0), map frame, metres
  double origin_y{0};              ///< y of the same
  std::vector<std::int8_t> cells;  ///< -1 unknown, 0 free, 100 occupied; index = row * width + column

  /// Centre of a cell, map frame, metres.
  [[nodiscard]] Eigen::Vector2d centre(int column, int row) const {
    return {origin_x + (column + 0.5) * resolution, origin_y + (row + 0.5) * resolution};
  }
};

}  // namespace yarm::slam

#include "yarm/ros/map_messages.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace yarm {

namespace {

constexpr double kMostTilt = 0.05;              // rad
constexpr std::array<int, 3> kPlanar{0, 1, 5};  // x, y, yaw among x, y, z, roll, pitch, yaw
constexpr double kMostVariance = 1e8;           // m^2, rad^2
constexpr double kLeastResolution = 0.001;      // m
constexpr double kMostResolution = 10.0;        // m
constexpr std::size_t kMostCells = std::size_t{1} << 26;

}  // namespace

std::optional<slam::Pose2> pose2Of(const geometry_msgs::Pose& message, std::string* reason) {
  const auto& p = message.position;
  const auto& q = message.orientation;
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  if (!std::isfinite(p.x + p.y + p.z) || !(std::abs(rotation.norm() - 1.0) < 1e-2)) {
    *reason = "its position must be finite and its quaternion of length 1, it has " + std::to_string(rotation.norm());
    return std::nullopt;
  }
  if (std::max(std::abs(p.x), std::abs(p.y)) > slam::kMostFar) {
    *reason = "it is " + std::to_string(std::max(std::abs(p.x), std::abs(p.y))) + " m off on an axis, at most " +
              std::to_string(slam::kMostFar);
    return std::nullopt;
  }
  const Eigen::Matrix3d axes = rotation.normalized().toRotationMatrix();
  if (!(axes(2, 2) > std::cos(kMostTilt))) {
    *reason = "it is tilted by more than " + std::to_string(kMostTilt) + " rad";
    return std::nullopt;
  }
  return slam::Pose2{p.x, p.y, std::atan2(axes(1, 0), axes(0, 0))};
}

std::optional<GridWithOrigin> gridOf(const nav_msgs::OccupancyGrid& message, std::string* reason) {
  const nav_msgs::MapMetaData& info = message.info;
  const std::size_t count = static_cast<std::size_t>(info.width) * info.height;
  if (message.data.size() != count || count == 0 || count > kMostCells) {
    *reason = "it has " + std::to_string(message.data.size()) + " cells for " + std::to_string(info.width) + " x " +
              std::to_string(info.height) + ", expected as many, 1 to " + std::to_string(kMostCells);
    return std::nullopt;
  }
  if (!(info.resolution >= kLeastResolution && info.resolution <= kMostResolution)) {
    *reason = "its cells are " + std::to_string(info.resolution) + " m wide, expected " +
              std::to_string(kLeastResolution) + " to " + std::to_string(kMostResolution) + " m";
    return std::nullopt;
  }
  const auto origin = pose2Of(info.origin, reason);
  if (!origin) {
    *reason = "its origin cannot be used: " + *reason;
    return std::nullopt;
  }
  GridWithOrigin result;
  result.T_map_grid = *origin;
  result.grid.width = static_cast<int>(info.width);
  result.grid.height = static_cast<int>(info.height);
  result.grid.resolution = info.resolution;
  result.grid.cells.assign(message.data.begin(), message.data.end());
  return result;
}

std::optional<slam::PoseBelief> beliefOf(const geometry_msgs::PoseWithCovariance& message, std::string* reason) {
  const auto pose = pose2Of(message.pose, reason);
  if (!pose) {
    return std::nullopt;
  }
  slam::PoseBelief belief;
  belief.pose = *pose;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      belief.covariance(row, column) = message.covariance[6 * kPlanar[row] + kPlanar[column]];
    }
  }
  if (!(belief.covariance.cwiseAbs().maxCoeff() <= kMostVariance)) {
    *reason = "its covariance must be finite and at most " + std::to_string(kMostVariance);
    return std::nullopt;
  }
  return belief;
}

geometry_msgs::Pose poseMessage(const slam::Pose2& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.x;
  message.position.y = pose.y;
  message.orientation.z = std::sin(0.5 * pose.yaw);
  message.orientation.w = std::cos(0.5 * pose.yaw);
  return message;
}

geometry_msgs::PoseWithCovariance beliefMessage(const slam::PoseBelief& belief) {
  geometry_msgs::PoseWithCovariance message;
  message.pose = poseMessage(belief.pose);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      message.covariance[6 * kPlanar[row] + kPlanar[column]] = belief.covariance(row, column);
    }
  }
  return message;
}

}  // namespace yarm

// Occupancy grids and poses as messages, and what is wrong with those that come.
#pragma once

#include "yarm/slam/localiser.hpp"
#include "yarm/slam/types.hpp"

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <nav_msgs/OccupancyGrid.h>

#include <optional>
#include <string>

namespace yarm {

/// A map in the frame of its own corner, and where that is.
struct GridWithOrigin {
  slam::GridMap grid;
  slam::Pose2 T_map_grid;
};

/// The map of a message; or nothing, with the reason.
std::optional<GridWithOrigin> gridOf(const nav_msgs::OccupancyGrid& message, std::string* reason);

/// The planar pose of a message; or nothing, with the reason.
std::optional<slam::Pose2> pose2Of(const geometry_msgs::Pose& message, std::string* reason);

/// The planar part of a pose with its covariance; or nothing, with the reason.
std::optional<slam::PoseBelief> beliefOf(const geometry_msgs::PoseWithCovariance& message, std::string* reason);

/// A planar pose as a message, at height 0.
geometry_msgs::Pose poseMessage(const slam::Pose2& pose);
/// The same with the covariance of x, y and heading.
geometry_msgs::PoseWithCovariance beliefMessage(const slam::PoseBelief& belief);

}  // namespace yarm

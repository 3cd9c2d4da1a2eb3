// Between ROS messages and the structs of the perception library.
#pragma once

#include "yarm/perception/merge.hpp"
#include "yarm/perception/types.hpp"
#include "yarm/perception/visibility.hpp"

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>
#include <yarm/AssociatedClusterVector.h>
#include <yarm/CarriedPiece.h>
#include <yarm/CloudVector.h>
#include <yarm/GridIndex.h>
#include <yarm/ObjectRegistry.h>
#include <yarm/PieceView.h>
#include <yarm/SeenCells.h>
#include <yarm/TransformStampedVector.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace yarm {

/// A ROS time in nanoseconds.
inline perception::StampNs toNs(const ros::Time& time) {
  return static_cast<perception::StampNs>(time.toNSec());
}
/// Nanoseconds as a ROS time; 0 for negative ones.
ros::Time toTime(perception::StampNs stamp_ns);

/// What a reader made of a message: value counts only when reason is empty.
template <class Value>
struct Read {
  Value value;
  std::string reason;
  bool ok() const { return reason.empty(); }
};

/// A strided view into the message's buffer (no copy; T_world_camera is left as it is), or why the layout cannot be
/// trusted. Only the layout is judged: sizes, offsets, types and byte order; the coordinates are not touched.
/// O(fields).
Read<perception::CameraCloud> viewOf(const sensor_msgs::PointCloud2& message);

/// The points of a merged set, as they lie in memory (fields x y z sigma ux uy uz camera). A point without coordinates
/// (NaN) says that its camera had no view in this set. `message` is used again.
void fillMergedPoints(const perception::MergedSet& set, sensor_msgs::PointCloud2& message);
/// The set's stamp, points and absent cameras; voxels and clusters are left empty. Refused when a point lies outside
/// the box.
Read<bool> readMergedPoints(const sensor_msgs::PointCloud2& message, const perception::MergeParams& box,
                            perception::MergedSet& set);

/// Centroids of the voxels (fields x y z).
void fillVoxels(const perception::MergedSet& set, sensor_msgs::PointCloud2& message);
/// The clusters, largest first.
void fillClusters(const perception::MergedSet& set, yarm::CloudVector& message);

/// The objects of a set with their points, and the grid they are to be binned into.
void fillAssociated(const perception::AssociatedSet& set, const perception::GridSpec& grid,
                    yarm::AssociatedClusterVector& message);
/// The same read back into `set` and `grid`; everything that makes no sense is named in the reason.
Read<bool> readAssociated(const yarm::AssociatedClusterVector& message, perception::AssociatedSet& set,
                          perception::GridSpec& grid);

/// What is seen of a piece of debris, with the object's name.
yarm::PieceView pieceMessage(const std::string& name, const perception::PieceView& view);
/// The same read back; empty when the message says of no points, refused when its numbers are not finite.
Read<std::optional<perception::PieceView>> readPiece(const yarm::PieceView& message);

/// How a piece of debris hangs on a robot's hand, with the piece's name.
yarm::CarriedPiece carriedMessage(const std::string& name, const perception::CarriedPiece& carried);
/// The same read back; empty when the message names no piece, refused without a robot or with an absurd pose.
Read<std::optional<perception::CarriedPiece>> readCarried(const yarm::CarriedPiece& message);

/// What the cameras see of the cells; the message's header and ages stay as they are.
void fillSeenCells(const perception::SeenCells& seen, yarm::SeenCells& message);
/// The same read back, refused when it does not fit `cells` cells or itself.
Read<bool> readSeenCells(const yarm::SeenCells& message, std::size_t cells, perception::SeenCells& seen);

/// Seeds of one message. Entries that make no sense are left out and named in the reason.
Read<std::vector<perception::Seed>> readSeeds(const yarm::TransformStampedVector& message);
/// Known shapes by object. Entries that make no sense are left out and named in the reason.
Read<perception::Knowledge> readRegistry(const yarm::ObjectRegistry& message);

/// Poses; a reason is given for numbers that are not finite and for quaternions of length zero.
Read<Eigen::Isometry3d> readPose(const geometry_msgs::Pose& pose);
/// A transform, as readPose reads poses.
Read<Eigen::Isometry3d> readTransform(const geometry_msgs::Transform& transform);
/// A pose as a transform, its quaternion of length one.
void fillTransform(const Eigen::Isometry3d& pose, geometry_msgs::Transform& transform);

/// Cells from their numbers in the grid.
std::vector<yarm::GridIndex> cellsOf(const perception::GridSpec& grid, const std::vector<std::int32_t>& indices);

}  // namespace yarm

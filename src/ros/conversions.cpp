#include "yarm/ros/conversions.hpp"

#include "yarm/perception/solids.hpp"
#include "yarm/ros/names.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm {

namespace {

using perception::AssociatedObject;
using perception::Solid;

Read<Eigen::Isometry3d> isometry(const geometry_msgs::Point& p, const geometry_msgs::Quaternion& q) {
  Read<Eigen::Isometry3d> read{Eigen::Isometry3d::Identity(), ""};
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  const Eigen::Vector3d position(p.x, p.y, p.z);
  const double norm = rotation.norm();
  if (!position.allFinite() || !std::isfinite(norm) || norm < 1e-6) {
    read.reason = "position or quaternion is not finite, or the quaternion has length 0";
    return read;
  }
  read.value.linear() = rotation.normalized().toRotationMatrix();
  read.value.translation() = position;
  read.reason = perception::poseFault(read.value);
  return read;
}

void addFault(std::string& faults, const std::string& fault) {
  faults += (faults.empty() ? "" : "; ") + fault;
}

void fillPoints(const std::vector<Eigen::Vector3f>& points, yarm::CloudPoints& message) {
  message.cloudpoints.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    message.cloudpoints[i].x = points[i].x();
    message.cloudpoints[i].y = points[i].y();
    message.cloudpoints[i].z = points[i].z();
  }
}

bool isAbsurd(const geometry_msgs::Point& p) {
  const double farthest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return !(farthest <= perception::kFarthestPose) || std::isnan(p.x + p.y + p.z);
}

Read<std::vector<Eigen::Vector3f>> readPoints(const yarm::CloudPoints& message) {
  Read<std::vector<Eigen::Vector3f>> read;
  read.value.reserve(message.cloudpoints.size());
  for (const geometry_msgs::Point& p : message.cloudpoints) {
    if (isAbsurd(p)) {
      read.reason = "point (" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " + std::to_string(p.z) +
                    ") m, each must be finite and at most " + std::to_string(perception::kFarthestPose);
      return read;
    }
    read.value.emplace_back(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
  }
  return read;
}

std::string readGrid(const yarm::AssociatedClusterVector& message, perception::GridSpec& grid) {
  grid.size = {message.gx, message.gy, message.gz};
  grid.min = {message.xmin, message.ymin, message.zmin};
  grid.max = {message.xmax, message.ymax, message.zmax};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool good = grid.size[axis] > 0 && grid.size[axis] <= 1000 && std::isfinite(grid.min[axis]) &&
                      std::isfinite(grid.max[axis]) && grid.max[axis] > grid.min[axis];
    if (!good) {
      return "the grid has " + std::to_string(grid.size[axis]) + " cells from " + std::to_string(grid.min[axis]) +
             " to " + std::to_string(grid.max[axis]) + " m on axis " + std::to_string(axis);
    }
  }
  return "";
}

Read<Solid> readSolid(const shape_msgs::SolidPrimitive& primitive, const geometry_msgs::Pose& pose,
                      const std::string& frame) {
  using shape_msgs::SolidPrimitive;
  Read<Solid> read;
  const auto& d = primitive.dimensions;
  const Read<Eigen::Isometry3d> placed = readPose(pose);
  Solid& solid = read.value;
  solid.T_frame_solid = placed.value;
  solid.frame = frame;
  if (!placed.ok()) {
    read.reason = placed.reason;
  } else if (primitive.type == SolidPrimitive::BOX && d.size() == 3) {
    solid.shape = Solid::Shape::kBox;
    solid.size = {d[SolidPrimitive::BOX_X], d[SolidPrimitive::BOX_Y], d[SolidPrimitive::BOX_Z]};
  } else if (primitive.type == SolidPrimitive::SPHERE && d.size() == 1) {
    solid.shape = Solid::Shape::kSphere;
    solid.size = {d[SolidPrimitive::SPHERE_RADIUS], 0.0, 0.0};
  } else if (primitive.type == SolidPrimitive::CYLINDER && d.size() == 2) {
    solid.shape = Solid::Shape::kCylinder;
    solid.size = {d[SolidPrimitive::CYLINDER_RADIUS], 0.0, d[SolidPrimitive::CYLINDER_HEIGHT]};
  } else {
    read.reason = "solid of type " + std::to_string(primitive.type) + " with " + std::to_string(d.size()) +
                  " dimensions; a box takes 3, a sphere 1, a cylinder 2";
  }
  if (read.ok()) {
    read.reason = perception::solidFault(solid);
  }
  return read;
}

}  // namespace

ros::Time toTime(perception::StampNs stamp_ns) {
  ros::Time time;
  time.fromNSec(stamp_ns > 0 ? static_cast<std::uint64_t>(stamp_ns) : 0);
  return time;
}

Read<Eigen::Isometry3d> readPose(const geometry_msgs::Pose& pose) {
  return isometry(pose.position, pose.orientation);
}

Read<Eigen::Isometry3d> readTransform(const geometry_msgs::Transform& transform) {
  geometry_msgs::Point position;
  position.x = transform.translation.x;
  position.y = transform.translation.y;
  position.z = transform.translation.z;
  return isometry(position, transform.rotation);
}

void fillTransform(const Eigen::Isometry3d& pose, geometry_msgs::Transform& transform) {
  const Eigen::Quaterniond rotation(pose.linear());
  transform.translation.x = pose.translation().x();
  transform.translation.y = pose.translation().y();
  transform.translation.z = pose.translation().z();
  transform.rotation.x = rotation.x();
  transform.rotation.y = rotation.y();
  transform.rotation.z = rotation.z();
  transform.rotation.w = rotation.w();
}

void fillAssociated(const perception::AssociatedSet& set, const perception::GridSpec& grid,
                    yarm::AssociatedClusterVector& message) {
  message.header.stamp = toTime(set.stamp_ns);
  message.header.frame_id = names::WORLD_FRAME;
  message.gx = grid.size[0];
  message.gy = grid.size[1];
  message.gz = grid.size[2];
  message.xmin = grid.min[0];
  message.xmax = grid.max[0];
  message.ymin = grid.min[1];
  message.ymax = grid.max[1];
  message.zmin = grid.min[2];
  message.zmax = grid.max[2];
  message.clusters.resize(set.objects.size());
  for (std::size_t i = 0; i < set.objects.size(); ++i) {
    const AssociatedObject& object = set.objects[i];
    yarm::AssociatedCluster& cluster = message.clusters[i];
    fillPoints(object.points, cluster.cloudpoints);
    fillPoints(object.hidden, cluster.hidden);
    cluster.attached_to = object.attached_to;
    cluster.transform.header.stamp = toTime(object.stamp_ns);
    cluster.transform.header.frame_id = names::WORLD_FRAME;
    cluster.transform.child_frame_id = object.name;
    fillTransform(object.T_world_seed, cluster.transform.transform);
    cluster.label = object.is_static ? "static" : "dynamic";
    cluster.frame = object.name;
    cluster.object = toString(object.object);
    cluster.unknown = object.is_unknown ? 1 : 0;
    if (object.piece) {
      cluster.piece = pieceMessage(object.name, *object.piece);
    }
    if (object.carried) {
      cluster.carried = carriedMessage(object.name, *object.carried);
    }
  }
}

yarm::PieceView pieceMessage(const std::string& name, const perception::PieceView& view) {
  yarm::PieceView message;
  message.name = name;
  message.points = static_cast<std::int32_t>(view.points);
  message.top.x = view.top.x();
  message.top.y = view.top.y();
  message.top.z = view.top.z();
  message.axis = view.axis_rad;
  message.length = view.length;
  message.width = view.width;
  message.cameras = view.cameras;
  return message;
}

Read<std::optional<perception::PieceView>> readPiece(const yarm::PieceView& message) {
  Read<std::optional<perception::PieceView>> read;
  if (message.points <= 0) {
    return read;
  }
  perception::PieceView view;
  view.points = static_cast<std::size_t>(message.points);
  view.top = {message.top.x, message.top.y, message.top.z};
  view.axis_rad = message.axis;
  view.length = message.length;
  view.width = message.width;
  view.cameras = message.cameras;
  if (view.top.allFinite() && std::isfinite(view.axis_rad + view.length + view.width)) {
    read.value = view;
  } else {
    read.reason = "what is seen of it must be finite numbers";
  }
  return read;
}

yarm::CarriedPiece carriedMessage(const std::string& name, const perception::CarriedPiece& carried) {
  yarm::CarriedPiece message;
  message.name = name;
  message.robot = carried.robot;
  geometry_msgs::Transform at_tip;
  fillTransform(carried.T_tip_piece, at_tip);
  message.pose.position.x = at_tip.translation.x;
  message.pose.position.y = at_tip.translation.y;
  message.pose.position.z = at_tip.translation.z;
  message.pose.orientation = at_tip.rotation;
  return message;
}

Read<std::optional<perception::CarriedPiece>> readCarried(const yarm::CarriedPiece& message) {
  Read<std::optional<perception::CarriedPiece>> read;
  if (message.name.empty()) {
    return read;
  }
  const Read<Eigen::Isometry3d> pose = readPose(message.pose);
  read.reason = message.robot.empty() ? "carried by a robot without a name" : pose.reason;
  if (read.ok()) {
    read.value = perception::CarriedPiece{message.robot, pose.value};
  }
  return read;
}

Read<bool> readAssociated(const yarm::AssociatedClusterVector& message, perception::AssociatedSet& set,
                          perception::GridSpec& grid) {
  Read<bool> read{true, readGrid(message, grid)};
  set.stamp_ns = toNs(message.header.stamp);
  set.objects.resize(message.clusters.size());
  for (std::size_t i = 0; i < message.clusters.size(); ++i) {
    const yarm::AssociatedCluster& cluster = message.clusters[i];
    AssociatedObject& object = set.objects[i];
    const Read<Eigen::Isometry3d> pose = readTransform(cluster.transform.transform);
    const auto kind = perception::fromString(cluster.object);
    if (!kind) {
      addFault(read.reason, cluster.frame + ": unknown kind '" + cluster.object + "'");
    }
    object.object = kind.value_or(perception::ObjectKind::kObstacle);
    if (!pose.ok()) {
      addFault(read.reason, cluster.frame + ": " + pose.reason);
    }
    object.name = cluster.frame;
    object.is_static = cluster.label == "static";
    object.is_unknown = cluster.unknown != 0;
    object.T_world_seed = pose.value;
    object.stamp_ns = toNs(cluster.transform.header.stamp);
    object.attached_to = cluster.attached_to;
    object.source.clear();
    const Read<std::optional<perception::PieceView>> piece = readPiece(cluster.piece);
    if (!piece.ok()) {
      addFault(read.reason, cluster.frame + ": " + piece.reason);
    }
    object.piece = piece.value;
    const Read<std::optional<perception::CarriedPiece>> carried = readCarried(cluster.carried);
    if (!carried.ok()) {
      addFault(read.reason, cluster.frame + ": " + carried.reason);
    }
    object.carried = carried.value;
    for (const auto& [cloud, points] :
         {std::make_pair(&cluster.cloudpoints, &object.points), std::make_pair(&cluster.hidden, &object.hidden)}) {
      Read<std::vector<Eigen::Vector3f>> taken = readPoints(*cloud);
      if (!taken.ok()) {
        addFault(read.reason, cluster.frame + ": " + taken.reason);
      }
      *points = std::move(taken.value);
    }
  }
  return read;
}

void fillSeenCells(const perception::SeenCells& seen, yarm::SeenCells& message) {
  message.cameras.clear();
  for (const Eigen::Vector3d& camera : seen.cameras) {
    geometry_msgs::Point point;
    point.x = camera.x();
    point.y = camera.y();
    point.z = camera.z();
    message.cameras.push_back(point);
  }
  message.states.resize(seen.states.size());
  std::transform(seen.states.begin(), seen.states.end(), message.states.begin(),
                 [](perception::CellState state) { return static_cast<std::int8_t>(state); });
  message.behind = seen.behind;
  message.unseen = seen.unseen;
}

Read<bool> readSeenCells(const yarm::SeenCells& message, std::size_t cells, perception::SeenCells& seen) {
  Read<bool> read{false, ""};
  constexpr auto kLast = static_cast<std::int8_t>(perception::CellState::kOccupied);
  const bool known = std::all_of(message.states.begin(), message.states.end(),
                                 [](std::int8_t state) { return state >= 0 && state <= kLast; });
  seen.states.resize(message.states.size());
  std::transform(message.states.begin(), message.states.end(), seen.states.begin(),
                 [](std::int8_t state) { return static_cast<perception::CellState>(state); });
  const auto unseen = static_cast<std::size_t>(
      std::count_if(seen.states.begin(), seen.states.end(), [](auto state) { return !perception::isSeen(state); }));
  if (!known) {
    addFault(read.reason, "states must be 0 to " + std::to_string(kLast));
  }
  if (message.states.size() != cells || (!message.age_s.empty() && message.age_s.size() != cells)) {
    addFault(read.reason, std::to_string(message.states.size()) + " states and " +
                              std::to_string(message.age_s.size()) + " ages, the map has " + std::to_string(cells) +
                              " cells; merge_clouds must have its grid (grid_node)");
  }
  if (message.behind.size() != unseen || message.unseen.size() != unseen) {
    addFault(read.reason, std::to_string(message.behind.size()) + " and " + std::to_string(message.unseen.size()) +
                              " entries for " + std::to_string(unseen) + " cells that are not seen");
  }
  if (message.cameras.size() > perception::kMostViews) {
    addFault(read.reason, std::to_string(message.cameras.size()) + " cameras, at most " +
                              std::to_string(perception::kMostViews) + " can be told apart");
  }
  seen.behind = message.behind;
  seen.unseen = message.unseen;
  seen.cameras.clear();
  for (const geometry_msgs::Point& camera : message.cameras) {
    seen.cameras.emplace_back(camera.x, camera.y, camera.z);
  }
  read.value = read.ok();
  return read;
}

Read<std::vector<perception::Seed>> readSeeds(const yarm::TransformStampedVector& message) {
  Read<std::vector<perception::Seed>> read;
  const std::size_t count = message.transforms.size();
  if (message.type.size() != count || message.frame.size() != count || message.object.size() != count) {
    read.reason = "transforms, type, frame and object differ in length";
    return read;
  }
  for (std::size_t i = 0; i < count; ++i) {
    perception::Seed seed;
    const Read<Eigen::Isometry3d> pose = readTransform(message.transforms[i].transform);
    const auto kind = perception::fromString(message.object[i]);
    if (!pose.ok() || !kind) {
      addFault(read.reason, message.frame[i] + ": " + (pose.ok() ? "unknown kind " + message.object[i] : pose.reason));
      continue;
    }
    seed.name = message.frame[i];
    seed.object = *kind;
    seed.is_static = message.type[i] == "static";
    seed.T_world_seed = pose.value;
    seed.stamp_ns = toNs(message.transforms[i].header.stamp);
    read.value.push_back(std::move(seed));
  }
  return read;
}

Read<perception::Knowledge> readRegistry(const yarm::ObjectRegistry& message) {
  Read<perception::Knowledge> read;
  for (const yarm::RegisteredObject& entry : message.entries) {
    perception::KnownObject known;
    known.seed_frame = entry.seed_frame;
    known.link_frames = entry.link_frames;
    if (entry.shape_poses.size() != entry.shapes.size() || entry.shape_frames.size() != entry.shapes.size()) {
      addFault(read.reason, entry.name + ": shapes, shape_poses and shape_frames differ in length");
    } else {
      for (std::size_t i = 0; i < entry.shapes.size(); ++i) {
        const Read<Solid> solid = readSolid(entry.shapes[i], entry.shape_poses[i], entry.shape_frames[i]);
        if (solid.ok()) {
          known.solids.push_back(solid.value);
        } else {
          addFault(read.reason, entry.name + ": " + solid.reason);
        }
      }
    }
    read.value[entry.name] = std::move(known);
  }
  return read;
}

std::vector<yarm::GridIndex> cellsOf(const perception::GridSpec& grid, const std::vector<std::int32_t>& indices) {
  std::vector<yarm::GridIndex> cells(indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const perception::Cell cell = grid.cellOf(indices[i]);
    cells[i].x = cell.x;
    cells[i].y = cell.y;
    cells[i].z = cell.z;
  }
  return cells;
}

}  // namespace yarm

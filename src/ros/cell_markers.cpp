#include "yarm/ros/cell_markers.hpp"

#include "yarm/ros/conversions.hpp"
#include "yarm/ros/names.hpp"

namespace yarm {

namespace {

using visualization_msgs::Marker;

constexpr double kMarkerSize = 0.98;  // of a cell, so that neighbours can be told apart

}  // namespace

Marker cubes(const perception::GridSpec& grid, perception::StampNs stamp_ns, const std::string& space,
             const std::vector<std::int32_t>& cells) {
  Marker marker;
  marker.header.stamp = toTime(stamp_ns);
  marker.header.frame_id = names::WORLD_FRAME;
  marker.ns = space;
  marker.type = Marker::CUBE_LIST;
  marker.action = cells.empty() ? Marker::DELETE : Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = kMarkerSize * grid.resolution(0);
  marker.scale.y = kMarkerSize * grid.resolution(1);
  marker.scale.z = kMarkerSize * grid.resolution(2);
  for (const std::int32_t index : cells) {
    const Eigen::Vector3d centre = grid.centre(grid.cellOf(index));
    geometry_msgs::Point point;
    point.x = centre.x();
    point.y = centre.y();
    point.z = centre.z();
    marker.points.push_back(point);
  }
  return marker;
}

}  // namespace yarm

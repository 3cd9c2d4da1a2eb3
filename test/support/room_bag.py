"""A bag of a robot that explores a room, as ``rosbag record`` writes it: a map, its place on it, a scan, marks."""

from __future__ import annotations

from pathlib import Path

import rosbag
import rospy
from geometry_msgs.msg import Pose, PoseArray, PoseStamped, TransformStamped
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Path as Way
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray
from yarm.msg import ExplorerStatus, InspectionStatus, TagVerdict

from yarm.ros.common import names

LENGTH_S, SPEED_MPS = 6.0, 0.2
ODOM_AT_M = (0.5, -0.25)
"""Of the odometry's frame on the map's."""
SHAPE, RESOLUTION_M, CORNER_M = (40, 60), 0.05, (-1.0, -0.8)
WALL_ROW = 3
SCAN_M = 1.5


def write_room_bag(path: Path, inspected: bool = False) -> Path:
    """A robot that drives along x, from 1 s on; explored, or with boxes that are inspected."""
    with rosbag.Bag(str(path), "w") as bag:
        for i in range(int(10 * LENGTH_S)):
            time_s = 1.0 + i / 10.0
            stamp = rospy.Time.from_sec(time_s)
            bag.write(
                "/tf",
                TFMessage(
                    [_link("map", "odom", *ODOM_AT_M), _link("odom", "base_footprint", SPEED_MPS * i / 10.0, 0.0)]
                ),
                stamp,
            )
            bag.write("/tf", TFMessage([_link("base_footprint", "camera_depth_frame", 0.1, 0.0)]), stamp)
            if i % 10 == 0:
                bag.write(names.MAP, _map(), stamp)
                bag.write(names.SCAN, _scan(), stamp)
                status = _inspection() if inspected else _exploration(time_s)
                bag.write(names.inspector("status") if inspected else names.explorer("status"), status, stamp)
                bag.write(names.inspector("markers") if inspected else names.explorer("frontiers"), _marks(), stamp)
                bag.write(names.PARTICLE_CLOUD, PoseArray(poses=[Pose(), Pose()]), stamp)
                bag.write(names.explorer("plan"), Way(poses=[PoseStamped(), PoseStamped()]), stamp)
    return path


def _link(parent, child, x, y):
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id = parent
    made.transform.translation.x, made.transform.translation.y, made.transform.rotation.w = x, y, 1.0
    return made


def _map():
    rows, columns = SHAPE
    made = OccupancyGrid(
        data=[100 if row == WALL_ROW else 0 if row > WALL_ROW else -1 for row in range(rows) for _ in range(columns)]
    )
    made.info.height, made.info.width, made.info.resolution = rows, columns, RESOLUTION_M
    made.info.origin.position.x, made.info.origin.position.y = CORNER_M
    made.info.origin.orientation.w = 1.0
    return made


def _scan():
    made = LaserScan(angle_min=0.0, angle_increment=0.1, range_min=0.45, range_max=10.0)
    made.header.frame_id = "camera_depth_frame"
    made.ranges = [SCAN_M, float("inf"), SCAN_M, 0.1]
    return made


def _marks():
    found = []
    for number, kind in enumerate((Marker.CUBE, Marker.TEXT_VIEW_FACING, Marker.LINE_STRIP, Marker.MESH_RESOURCE)):
        made = Marker(id=number, type=kind, text="7: tag 3")
        made.header.frame_id = "map"
        made.pose.orientation.w = 1.0
        made.scale.x = made.scale.y = made.scale.z = 0.2
        made.color.g = made.color.a = 1.0
        made.points = [Pose().position, Pose().position]
        found.append(made)
    return MarkerArray(found)


def _exploration(time_s):
    return ExplorerStatus(
        state="exploring", behaviour="frontier", left=300.0 - time_s, known_m2=4.5, travelled=1.2, bumps=1
    )


def _inspection():
    verdict = TagVerdict(box=7, tag=3, probability=0.998, finding="in place")
    strange = TagVerdict(box=8, tag=TagVerdict.UNKNOWN, probability=0.9, finding="moved", reason="no tag of the list")
    return InspectionStatus(stage="drive", box=8, left=100.0, time_home=20.0, verdicts=[verdict, strange])

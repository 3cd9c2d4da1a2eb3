"""Node ``map_server``: offers a map file on topics ``map`` and ``map_metadata`` and by service ``static_map``.

map_server MAP.yaml [map:=TOPIC] [_boxes:=BOXES.yaml]; boxes whose places are known are drawn into it
"""

from __future__ import annotations

import argparse
from pathlib import Path

import rospy
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap, GetMapRequest, GetMapResponse

from yarm.inspection.boxes import extent_of, outside
from yarm.inspection.inputs import read_boxes
from yarm.navigation.bodies import with_bodies
from yarm.navigation.grid_map import GridMap
from yarm.navigation.map_file import MapFileError, read_map
from yarm.params import ParamError
from yarm.ros.common import names
from yarm.ros.common.clock import ClockWatch
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.ros.navigation.maps import grid_message
from yarm.ros.navigation.params import MapServerParams
from yarm.yaml_fields import Faults, SceneError


class MapServer:
    """Publishes the map once, latched, and again with a new stamp when simulated time has gone backwards."""

    def __init__(self, grid: GridMap, params: MapServerParams) -> None:
        """Start at once."""
        self._grid, self._params = grid, params
        self._map = rospy.Publisher(names.MAP, OccupancyGrid, queue_size=1, latch=True)
        self._metadata = rospy.Publisher(names.MAP_METADATA, MapMetaData, queue_size=1, latch=True)
        self._publish()
        self._service = rospy.Service(names.STATIC_MAP, GetMap, self._on_request)
        self._clock = ClockWatch()
        self._clock.on_reset(self._publish)

    def spin(self) -> None:
        """Serve until the node is shut down."""
        rospy.spin()

    def _publish(self) -> None:
        self._message = grid_message(self._grid, self._params.frame_id, rospy.Time.now())
        self._metadata.publish(self._message.info)
        self._map.publish(self._message)

    def _on_request(self, _: GetMapRequest) -> GetMapResponse:
        return GetMapResponse(self._message)


def drawn(grid: GridMap, boxes: str) -> GridMap:
    """The map with the boxes of a file in it; the map itself when no file is named.

    Raises:
        SceneError: the file is faulty, or boxes lie outside the map.
    """
    if not boxes:
        return grid
    read = read_boxes(Path(boxes).expanduser())
    faults = Faults(boxes)
    for box in outside(read, grid):
        faults.add(f"box {box.number}", (box.pose.x, box.pose.y), f"a place in the map, {extent_of(grid)}")
    faults.raise_if_any()
    return with_bodies(grid, [box.corners() for box in read])


def main() -> int:
    """Serve a map until the node is shut down; 1 when it or the parameters were refused."""
    parser = argparse.ArgumentParser(prog="map_server", description="Offers a map file to others.")
    parser.add_argument("map", type=Path, help="the YAML of the map")
    path = parser.parse_args(rospy.myargv()[1:]).map
    init_node("map_server")
    try:
        params = load_params(MapServerParams)
        server = MapServer(drawn(read_map(path), params.boxes), params)
    except (MapFileError, ParamError, SceneError) as error:
        rospy.logfatal(str(error))
        return 1
    rospy.loginfo("%s: served on %s", path, rospy.resolve_name(names.MAP))
    server.spin()
    return 0

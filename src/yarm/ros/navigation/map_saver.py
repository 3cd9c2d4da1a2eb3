"""Node ``map_saver``: writes the map of a topic to a file and ends.

map_saver [-f NAME] [--occ 65] [--free 25] [--wait 60] [map:=TOPIC]
"""

from __future__ import annotations

import argparse
import threading
import time
from pathlib import Path
from typing import List, Optional

import rospy
from nav_msgs.msg import OccupancyGrid

from yarm.navigation.grid_map import FREE_AT_MOST, OCCUPIED_AT_LEAST
from yarm.navigation.map_file import MapFileError, thresholds_fault, write_map, writing_fault
from yarm.ros.common import names
from yarm.ros.common.start import init_command
from yarm.ros.navigation.maps import grid_fault, grid_of

SAY_AGAIN_S = 5.0
"""Wall time between two words about a map that does not come, s."""


def parse(arguments: List[str]) -> argparse.Namespace:
    """What the command line asks for; ends the program when it asks for what cannot be."""
    parser = argparse.ArgumentParser(prog="map_saver", description="Writes the map of topic `map` to a file.")
    parser.add_argument("-f", dest="name", type=Path, default=Path("map"), help="NAME.pgm and NAME.yaml are written")
    parser.add_argument(
        "--occ", type=int, default=OCCUPIED_AT_LEAST, help="from this value on a cell is occupied, 1 to 100"
    )
    parser.add_argument("--free", type=int, default=FREE_AT_MOST, help="up to this value a cell is free, below --occ")
    parser.add_argument("--wait", type=float, default=60.0, help="wall seconds to wait for the map")
    given = parser.parse_args(arguments)
    fault = thresholds_fault(given.occ, given.free) or writing_fault(given.name)
    if fault:
        parser.error(fault)
    return given


def wait_for_map(limit_s: float) -> Optional[OccupancyGrid]:
    """The first usable map; None when none came within so much wall time, or the node was shut down."""
    came = threading.Event()
    received: List[OccupancyGrid] = []

    def on_map(message: OccupancyGrid) -> None:
        fault = grid_fault(message)
        if fault:
            rospy.logwarn("%s: a map is left out: %s", subscriber.resolved_name, fault)
        else:
            received.append(message)
            came.set()

    subscriber = rospy.Subscriber(names.MAP, OccupancyGrid, on_map, queue_size=1)
    end_s = time.monotonic() + limit_s
    while not came.wait(min(SAY_AGAIN_S, max(0.0, end_s - time.monotonic()))):
        publishers, left_s = subscriber.get_num_connections(), end_s - time.monotonic()
        if left_s <= 0.0 or rospy.is_shutdown():
            break
        rospy.loginfo("%s: no map yet, %d publishers; %.0f s left", subscriber.resolved_name, publishers, left_s)
    subscriber.unregister()
    return received[0] if received else None


def main() -> int:
    """Save one map; 0 when it was saved."""
    given = parse(rospy.myargv()[1:])
    init_command("map_saver")
    message = wait_for_map(given.wait)
    if message is None:
        rospy.logfatal("%s: no map within %.0f s; who publishes it?", rospy.resolve_name(names.MAP), given.wait)
        return 1
    try:
        files = write_map(grid_of(message), given.name, given.occ, given.free)
    except MapFileError as error:
        rospy.logfatal(str(error))
        return 1
    info = message.info
    rospy.loginfo("a map of %d x %d cells of %.3f m saved: %s", info.width, info.height, info.resolution, files.image)
    return 0

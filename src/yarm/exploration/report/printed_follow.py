"""The report's printed way along a frontier path, faults included; the loop never gets a path to call it with.

What it takes for its heading is no angle, its place leaves out how the odometry frame is turned in the map, it steers
away from the path, and the wait that ends a short one looks at a variable that nothing sets.
"""

from __future__ import annotations

import math
from typing import Generator, Tuple

from yarm.exploration.model import Command
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.view import View
from yarm.geometry import FloatArray, Pose2, wrap_angle

SHORT_CELLS = 6
SHORT_END_CELLS = 2
FIRST_TOLERANCE, FIRST_TO_GO, ADVANCE = 2, 4, 2
END_CELLS = 3
"""It ends when the cell to go to is this near to the last one, counted along the path."""

Motion = Generator[Tuple[str, Command], View, View]


def printed_heading(odom: Pose2, map_from_odom: Pose2) -> float:
    """What it takes for the heading in the map, rad: the odometry's x, metres, and the frame's quaternion z."""
    return odom.x + math.sin(0.5 * map_from_odom.yaw_rad)


def printed_place(odom: Pose2, map_from_odom: Pose2) -> Tuple[float, float]:
    """Where it holds itself to be in the map, metres: shifted as the frame is, and not turned."""
    return odom.x + map_from_odom.x, odom.y + map_from_odom.y


def printed_follow(view: View, points: FloatArray, cell_m: float) -> Motion:
    """Turn and drive along (n, 2) points, map, metres; what it yields is driven for a pass."""
    last = len(points) - 1
    if last < 1:
        return view
    if len(points) < SHORT_CELLS:
        view = yield from _turn(view, points[last])
        while _error(view, points[last])[1] > SHORT_END_CELLS * cell_m:
            view = yield "frontier", _ahead(view, points[last])
        while True:
            yield "frontier", Command()
    tolerance, to_go = FIRST_TOLERANCE, FIRST_TO_GO
    view = yield from _turn(view, points[to_go])
    while to_go < last - END_CELLS:
        view = yield "frontier", _ahead(view, points[to_go])
        if _error(view, points[tolerance])[1] <= 4 * cell_m:
            tolerance, to_go = tolerance + ADVANCE, to_go + ADVANCE
    return view


def _turn(view: View, point: FloatArray) -> Motion:
    params = ReportParams()
    while abs(_error(view, point)[0]) > params.follow_aligned:
        view = yield "frontier", Command(0.0, params.angular_max * _error(view, point)[0])
    return view


def _ahead(view: View, point: FloatArray) -> Command:
    """Steered by the error with the wrong sign."""
    params = ReportParams()
    turn = -params.follow_gain * _error(view, point)[0]
    return Command(params.follow_share * params.speed, max(-params.angular_max, min(params.angular_max, turn)))


def _error(view: View, point: FloatArray) -> Tuple[float, float]:
    """Of heading, rad, and distance, metres, to a point, as it holds them to be."""
    frame = view.observation.map_from_odom or Pose2(0.0, 0.0)
    x, y = printed_place(view.odom, frame)
    bearing = math.atan2(point[1] - y, point[0] - x)
    return wrap_angle(bearing - printed_heading(view.odom, frame)), math.hypot(point[0] - x, point[1] - y)

"""What the cell's messages say, in the words and drawings that a page gets."""

from __future__ import annotations

import math
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import rospy
from visualization_msgs.msg import Marker, MarkerArray

from yarm.commander.requests import Situation
from yarm.commander.states import STATE_DOCS, State
from yarm.console.buttons import buttons
from yarm.console.picture import Area, BodyDrawing, CameraDrawing, Line
from yarm.geometry import GridSpec
from yarm.msg import CommanderStatus, PlanReport, RegisteredObject, SafetyStatus, SimStatus
from yarm.params import ParamError
from yarm.robots.hc10 import Station, parse_area
from yarm.ros.common import names
from yarm.ros.common.solids import solids_of
from yarm.ros.common.stations import load_station
from yarm.ros.common.status_age import STALE_S
from yarm.ros.controls.params import ControlsServerParams
from yarm.sim.sensors.camera_model import KINECT, OVERHEAD_POSITIONS_M

PATH_M = 0.95
"""Height at which ways ahead are drawn, metres."""
DISC_M, CORNERS = 0.03, 32
"""Height at which discs on the floor are drawn, metres, and corners that a circle is drawn with."""


def drawing_of(entry: RegisteredObject) -> BodyDrawing:
    """What the registry knows of an object."""
    solids = [(frame.lstrip("/"), solid) for frame, solid in solids_of(entry)]
    return BodyDrawing(entry.name, entry.object, entry.type, entry.seed_frame.lstrip("/"), solids)


def cameras() -> List[CameraDrawing]:
    """The overhead cameras."""
    half_rad = 0.5 * KINECT.fov_rad
    down_rad = math.atan(math.tan(half_rad) * KINECT.height / KINECT.width)
    return [
        CameraDrawing(
            f"camera {number}", names.camera_optical_frame(number), names.camera_points(number), half_rad, down_rad
        )
        for number in range(1, len(OVERHEAD_POSITIONS_M) + 1)
    ]


def private_areas(arms: Sequence[str]) -> List[Area]:
    """The area each manipulator keeps clear for itself, from the parameters of its station and its server."""
    text = rospy.get_param("multi_robot_controls_server/manipulator_area", ControlsServerParams.manipulator_area)
    found = []
    for arm in arms:
        try:
            found.append(private_area(arm, load_station(arm), str(text)))
        except (ParamError, ValueError) as error:
            rospy.logwarn("private area of %s is not shown: %s", arm, error)
    return found


def private_area(arm: str, station: Station, text: str = ControlsServerParams.manipulator_area) -> Area:
    """The area that a manipulator at a station keeps clear for itself.

    Args:
        arm: its name.
        station: where it stands.
        text: the area of one at the origin, as the server has it.

    Raises:
        ValueError: the area is none.
    """
    spec = GridSpec()
    x0, x1, y0, y1, _, _ = station.moved_area(spec, parse_area(text))
    lower, size = np.asarray(spec.lower), spec.resolution
    low, high = lower[:2] + (x0, y0) * size[:2], lower[:2] + (x1 + 1, y1 + 1) * size[:2]
    return Area(arm, (*low.tolist(), 0.0), (*high.tolist(), 0.02))


def ways_ahead(report: Optional[PlanReport], spec: GridSpec) -> List[Line]:
    """The paths of the newest plan."""
    if report is None:
        return []
    found = []
    for name, path in zip(report.robots, report.paths):
        columns = np.array([(index.x, index.y) for index in path.indices], dtype=float).reshape(-1, 2)
        xy = np.asarray(spec.lower[:2]) + (columns + 0.5) * spec.resolution[:2]
        found.append(Line("path", name, np.column_stack([xy, np.full(len(xy), PATH_M)])))
    return found


def commander_words(status: Optional[CommanderStatus]) -> Dict[str, Any]:
    """State, buttons and tasks; nothing while the Commander has not been heard."""
    if status is None or status.state not in State._value2member_map_:
        return {"commander": None, "buttons": [], "tasks": []}
    succeeded = status.outcome == "succeeded"
    situation = Situation(State(status.state), status.busy, succeeded, status.reason)
    return {
        "commander": {
            "state": status.state_name,
            "means": STATE_DOCS[State(status.state)],
            "busy": status.busy,
            "outcome": status.outcome,
            "reason": status.reason,
            "elapsed_s": finite(status.elapsed_s),
        },
        "buttons": [vars(button) for button in buttons(situation)],
        "tasks": [
            {
                "robot": task.robot,
                "goal": task.goal,
                "kind": task.kind,
                "status": task.status,
                "reason": task.reason,
                "left_m": finite(task.distance_left_m),
            }
            for task in status.tasks
        ],
    }


def safety_words(status: Optional[SafetyStatus]) -> Dict[str, Any]:
    """Whether everything is stopped, and each robot's room ahead."""
    if status is None:
        return {"stop": None, "robots": []}
    rows = zip(status.robots, status.clearance_m, status.nearest, status.stopped)
    return {
        "stop": {"latched": status.latched, "reason": status.reason},
        "robots": [
            {"name": name, "clearance_m": finite(clearance), "nearest": nearest, "held": held}
            for name, clearance, nearest, held in rows
        ],
    }


def people_discs(message: Optional[MarkerArray]) -> List[Line]:
    """The discs in which people may be before a robot stands, as the safety monitor says."""
    found = []
    turns = np.linspace(0.0, 2.0 * math.pi, CORNERS + 1)
    for each in message.markers if message is not None else ():
        numbers = (each.pose.position.x, each.pose.position.y, each.scale.x)
        if each.action != Marker.ADD or not all(map(math.isfinite, numbers)):
            continue
        x, y, width = numbers
        circle = np.column_stack([x + 0.5 * width * np.cos(turns), y + 0.5 * width * np.sin(turns)])
        found.append(Line("people", each.ns, np.column_stack([circle, np.full(len(turns), DISC_M)])))
    return found


def server_words(heard: Mapping[str, Tuple[float, float]], wall_s: float, now_s: float) -> List[Dict[str, Any]]:
    """Whether the action server of each robot and arm answers.

    Args:
        heard: when each was heard last: by a clock on the wall, and simulated time, s; infinitely long ago for never.
        wall_s: the clock on the wall now, s.
        now_s: simulated time, s.
    """
    found = []
    for name, (wall, simulated) in sorted(heard.items()):
        silent_s = min(wall_s - wall, abs(now_s - simulated))
        level, text = ("ok", "answers") if silent_s <= STALE_S else ("error", f"silent for {silent_s:.0f} s")
        if math.isinf(silent_s):
            level, text = "stale", "not heard yet"
        found.append({"name": f"action server of {name}", "level": level, "text": text})
    return found


def speed_words(status: Optional[SimStatus]) -> Dict[str, Any]:
    """Simulated seconds for a second, when there is a simulator."""
    return {"real_time_factor": None if status is None else finite(status.real_time_factor)}


def finite(value: float) -> Optional[float]:
    """A number that JSON can say; None for one it cannot."""
    return round(float(value), 4) if math.isfinite(value) else None

"""What RViz shows of an inspection, as markers in the map's frame: boxes by verdict, viewpoints, tour, time left."""

from __future__ import annotations

import textwrap
from typing import List, Mapping, Optional, Sequence, Tuple

import numpy as np
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from yarm.geometry import FloatArray, Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.model import BLANK, UNKNOWN, UNSEEN, Verdict
from yarm.inspection.session import SessionStep
from yarm.inspection.viewpoints import Viewpoint
from yarm.ros.common.pictures import Color, marker, points, text
from yarm.ros.exploration.drawing import arrow

NOT_YET: Color = (0.6, 0.6, 0.6, 0.8)
NAMED: Color = (0.1, 0.75, 0.2, 0.9)
EMPTY: Color = (0.95, 0.95, 0.95, 0.9)
STRANGE: Color = (0.95, 0.75, 0.1, 0.9)
NO_VERDICT: Color = (0.9, 0.1, 0.1, 0.9)
NOW: Color = (0.15, 0.45, 0.95, 0.9)
DARK: Color = (0.2, 0.05, 0.35, 1.0)
FACE: Color = (0.05, 0.05, 0.05, 1.0)
HOME: Color = (0.55, 0.2, 0.75, 0.9)
TEXT_ABOVE_M, STATE_ABOVE_M = 0.15, 0.9
LINE_LENGTH, MOST_LINES = 60, 4
WORDS = {BLANK: "blank", UNKNOWN: "unknown", UNSEEN: "no verdict"}


def verdict_words(verdict: Verdict) -> str:
    """What is written above a box."""
    reading = verdict.reading
    words = WORDS.get(reading.tag, f"tag {reading.tag}")
    words += " (duplicate)" if verdict.duplicate else ""
    words += f" {reading.probability:.3f}" if reading.tag != UNSEEN else ""
    return f"{words}\n{reading.note}" if reading.note else words


def box_color(verdict: Optional[Verdict], now: bool) -> Color:
    """By verdict; the box that the round is at is blue while it has none."""
    if verdict is None:
        return NOW if now else NOT_YET
    return {BLANK: EMPTY, UNKNOWN: STRANGE, UNSEEN: NO_VERDICT}.get(verdict.reading.tag, NAMED)


def box_markers(boxes: Sequence[Box], verdicts: Mapping[int, Verdict], now: int, height_m: float) -> List[Marker]:
    """Every box with its number, the side with the tag, and its verdict."""
    made: List[Marker] = []
    for box in boxes:
        verdict = verdicts.get(box.number)
        corners = box.corners()
        solid = marker("boxes", Marker.CUBE, box_color(verdict, box.number == now), _measures(corners, height_m))
        solid.pose.position.x, solid.pose.position.y, solid.pose.position.z = box.pose.x, box.pose.y, 0.5 * height_m
        solid.pose.orientation.z, solid.pose.orientation.w = np.sin(box.pose.yaw_rad / 2), np.cos(box.pose.yaw_rad / 2)
        words = f"{box.number}" if verdict is None else f"{box.number}: {verdict_words(verdict)}"
        made += [solid, arrow("faces", box.face, 0.12, FACE)]
        made.append(text("verdicts", words, (box.pose.x, box.pose.y, height_m + TEXT_ABOVE_M), 0.14))
    return made


def _measures(corners: FloatArray, height_m: float) -> Tuple[float, float, float]:
    """Along the box's own x and y, metres."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    return float(sides[0]), float(sides[1]), height_m


def way_markers(here: Optional[Pose2], home: Optional[Pose2], tour: Sequence[Viewpoint]) -> List[Marker]:
    """Viewpoints that are planned, the tour through them, home."""
    made = [arrow("viewpoints", view.pose, 0.25, NOW) for view in tour]
    if home is not None:
        made.append(arrow("home", home, 0.35, HOME))
    if here is not None and home is not None and tour:
        line = marker("tour", Marker.LINE_STRIP, (*NOW[:3], 0.6), (0.02, 0.0, 0.0))
        stops = [here, *[view.pose for view in tour], home]
        line.points = points(np.array([(stop.x, stop.y, 0.03) for stop in stops]))
        made.append(line)
    return made


def state_marker(step: SessionStep, verdicts: int, boxes: int, base_frame: str) -> Marker:
    """On the robot: stage, verdicts, time left and time home, the reason."""
    minutes, seconds = divmod(max(0, int(step.left_s)), 60)
    lines = [
        f"{step.stage}{f' box {step.box}' if step.box else ''}: {verdicts} of {boxes} boxes",
        f"{minutes:d}:{seconds:02d} left, {step.time_home_s:.0f} s home",
        *textwrap.wrap(step.reason, LINE_LENGTH)[:MOST_LINES],
    ]
    made = text("state", "\n".join(lines), (0.0, 0.0, STATE_ABOVE_M), 0.18)
    made.color = ColorRGBA(*DARK)
    made.header.frame_id, made.frame_locked = base_frame, True
    return made

"""What RViz shows of an exploration, as markers in the map's frame: frontiers, goal and its view, bumps, state."""

from __future__ import annotations

import math
import textwrap
from typing import List, Sequence, Tuple

import numpy as np
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from yarm.exploration.model import FrontierView
from yarm.exploration.session import SessionStep, State
from yarm.geometry import FloatArray, Pose2
from yarm.robots.turtlebot import RADIUS_M, SCAN_FOV_RAD, SCAN_VALID_M
from yarm.ros.common.pictures import Color, marker, points, text

RED: Color = (0.9, 0.1, 0.1, 0.9)
BLUE: Color = (0.15, 0.45, 0.95, 0.9)
VIEW: Color = (0.15, 0.45, 0.95, 0.5)
DARK: Color = (0.45, 0.05, 0.45, 1.0)
BLACK: Color = (0.0, 0.0, 0.0, 1.0)
ORANGE: Color = (1.0, 0.55, 0.0, 0.9)
FLOOR_M, TEXT_M = 0.05, 0.5
STATE_ABOVE_M = 0.9
"""The state stands so far above the robot."""
LINE_LENGTH, MOST_LINES = 60, 4


def frontier_markers(frontiers: Sequence[FrontierView]) -> List[Marker]:
    """Candidates from yellow (the least score) to green (the greatest); refused ones red, with the reason."""
    scores = [f.score for f in frontiers if not f.refused and math.isfinite(f.score)]
    low, high = (min(scores), max(scores)) if scores else (0.0, 1.0)
    made: List[Marker] = []
    for frontier in frontiers:
        color = RED if frontier.refused else score_color(frontier.score, low, high)
        dot = marker("refused" if frontier.refused else "frontiers", Marker.SPHERE, color, (0.12, 0.12, 0.12))
        _put(dot, frontier.x, frontier.y, FLOOR_M)
        made.append(dot)
        if frontier.refused:
            made.append(text("reasons", frontier.refused, (frontier.x, frontier.y, TEXT_M), 0.10))
    return made


def score_color(score: float, low: float, high: float) -> Color:
    """Yellow at the lower end, green at the upper; what is no number is grey."""
    if not math.isfinite(score):
        return (0.6, 0.6, 0.6, 0.9)
    share = 1.0 if high <= low else min(1.0, max(0.0, (score - low) / (high - low)))
    return (1.0 - share, 0.85, 0.1, 0.9)


def bump_markers(places: Sequence[Pose2]) -> List[Marker]:
    """A flat disc of the robot's size at every place where it bumped, and an arrow the way it looked."""
    made: List[Marker] = []
    for place in places:
        disc = marker("bumps", Marker.CYLINDER, (*ORANGE[:3], 0.4), (2.0 * RADIUS_M, 2.0 * RADIUS_M, 0.02))
        _put(disc, place.x, place.y, FLOOR_M)
        made += [disc, arrow("bumps_heading", place, RADIUS_M + 0.1, ORANGE)]
    return made


def view_markers(step: SessionStep, base_frame: str) -> List[Marker]:
    """On the robot its footprint, state, time left, what is known; in the map the goal with what it would see."""
    turn = np.linspace(-math.pi, math.pi, 33)
    rim = marker("footprint", Marker.LINE_STRIP, BLACK, (0.015, 0.0, 0.0))
    rim.points = points(np.stack([RADIUS_M * np.cos(turn), RADIUS_M * np.sin(turn), np.full(33, FLOOR_M)], axis=1))
    made = [rim, state_text(step)]
    for own in made:
        own.header.frame_id, own.frame_locked = base_frame, True
    goal = step.intent.goal
    if goal is not None and step.state in (State.EXPLORING, State.RETURNING):
        cone = marker("goal_view", Marker.LINE_STRIP, VIEW, (0.02, 0.0, 0.0))
        cone.points = points(np.column_stack([view_outline(goal), np.full(len(view_outline(goal)), FLOOR_M)]))
        made += [arrow("goal", goal, 0.4, BLUE), cone]
    return made


def state_text(step: SessionStep) -> Marker:
    """State, behaviour, time left, area, bumps; below it the reason, as much of it as can be read."""
    minutes, seconds = divmod(int(step.left_s), 60)
    lines = [
        f"{step.state.value}: {step.behaviour}",
        f"{minutes:d}:{seconds:02d} left, {step.known_m2:.1f} m2, {step.bumps} bumps",
        *textwrap.wrap(step.reason, LINE_LENGTH)[:MOST_LINES],
    ]
    made = text("state", "\n".join(lines), (0.0, 0.0, STATE_ABOVE_M), 0.18)
    made.color = ColorRGBA(*DARK)
    return made


def view_outline(pose: Pose2, radius_m: float = SCAN_VALID_M, steps: int = 12) -> FloatArray:
    """(n, 2) the closed outline of what the camera sees from a pose, map frame, metres."""
    bearings = pose.yaw_rad + np.linspace(-0.5, 0.5, steps) * SCAN_FOV_RAD
    arc = np.stack([pose.x + radius_m * np.cos(bearings), pose.y + radius_m * np.sin(bearings)], axis=1)
    eye = np.array([[pose.x, pose.y]])
    return np.concatenate([eye, arc, eye])


def arrow(space: str, pose: Pose2, length_m: float, color: Color) -> Marker:
    """An arrow from a pose the way it looks."""
    made = marker(space, Marker.ARROW, color, (0.03, 0.07, 0.08))
    tip = pose.compose(Pose2(length_m, 0.0))
    ends: Tuple[Tuple[float, float, float], ...] = ((pose.x, pose.y, FLOOR_M), (tip.x, tip.y, FLOOR_M))
    made.points = points(np.array(ends))
    return made


def _put(made: Marker, x: float, y: float, z: float) -> None:
    made.pose.position.x, made.pose.position.y, made.pose.position.z = x, y, z

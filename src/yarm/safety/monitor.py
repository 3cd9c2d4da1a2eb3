"""The safety monitor without ROS: poses and goals in, holds out."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from typing import Deque, Dict, List, Mapping, Optional, Sequence, Set, Tuple

from yarm.geometry import FloatArray, Pose2, wrap_angle
from yarm.safety.clearance import Ahead, Body, Foresight, Motion, coasting, placed, room_ahead
from yarm.safety.params import SafetyParams
from yarm.safety.people import NOBODY, Apart, separation


@dataclass(frozen=True, eq=False)
class Seen:
    """One robot at one time.

    Attributes:
        pose: of its end effector.
        height_m: of its end effector above the floor.
        points: (n, 3) on its surface, in the end effector's frame.
        target: where it was sent; None without a goal.
        goal_id: of the goal it pursues; empty without one.
        age_s: of the pose.
        via: poses that it goes by on its way to the target and has not passed.
    """

    pose: Pose2
    height_m: float
    points: FloatArray
    target: Optional[Pose2] = None
    goal_id: str = ""
    age_s: float = 0.0
    via: Tuple[Pose2, ...] = ()


@dataclass(frozen=True)
class Verdict:
    """What the monitor thinks of a robot.

    Attributes:
        ahead: room ahead of its motion.
        held: it is to stand still.
        stop_now: it has just been stopped: cancel its goals.
        reason: why it was stopped; empty when it is not held.
        apart: from whoever moves by himself.
    """

    ahead: Ahead
    held: bool
    stop_now: bool
    reason: str
    apart: Apart = NOBODY


@dataclass
class _Hold:
    since_s: float
    reason: str
    goal_id: str


class Monitor:
    """Watches a fleet; call ``look`` with every new set of poses."""

    def __init__(self, params: SafetyParams) -> None:
        """Nothing seen yet."""
        self._params = params
        self._sight = Foresight(params.latency_s, params.deceleration_mps2, params.reach_m)
        self._history: Dict[str, Deque[Tuple[float, Pose2]]] = {}
        self._holds: Dict[str, _Hold] = {}
        self._unseen: Set[str] = set()

    def reset(self) -> None:
        """Time went backwards."""
        self._history.clear()
        self._holds.clear()
        self._unseen.clear()

    def look(
        self, now_s: float, robots: Mapping[str, Seen], bodies: Mapping[str, Sequence[Body]]
    ) -> Dict[str, Verdict]:
        """Judge every robot.

        Args:
            now_s: time of the poses, s.
            robots: by name.
            bodies: by robot, everything it must not touch.
        """
        for name in set(self._history) - set(robots):
            self._history.pop(name)
            self._holds.pop(name, None)
        verdicts = {name: self._judge(now_s, name, seen, bodies[name]) for name, seen in sorted(robots.items())}
        return {name: replace(v, apart=self._apart(name, robots[name], bodies[name])) for name, v in verdicts.items()}

    def _apart(self, name: str, seen: Seen, bodies: Sequence[Body]) -> Apart:
        """From the person that is nearest to coming too near."""
        motion = self._moved(name)
        points = placed(seen.points, seen.pose, seen.height_m)
        found = [separation(points, motion, body, self._sight, self._params.stop_clearance_m) for body in bodies]
        return min((apart for apart in found if apart.who), key=lambda apart: apart.room_m, default=NOBODY)

    def _judge(self, now_s: float, name: str, seen: Seen, bodies: Sequence[Body]) -> Verdict:
        if seen.age_s > self._params.stale_s:
            return self._blind(name, seen.age_s)
        self._unseen.discard(name)
        motion = self._measure(now_s, name, seen.pose)
        hold = self._holds.get(name)
        fresh = hold is None or seen.goal_id not in ("", hold.goal_id)
        passed = coasting(seen.pose, motion, seen.target if fresh else None, self._sight, seen.via)
        ahead = room_ahead(seen.points, seen.pose, seen.height_m, passed, bodies, self._params.stop_clearance_m)
        if hold is not None:
            moving = motion.fastest_mps(self._params.reach_m) > self._params.still_mps
            return self._keep(hold, now_s, name, seen, ahead, moving, fresh)
        if not ahead.closing:
            return Verdict(ahead, False, False, "")
        return self._stop(now_s, name, seen, ahead)

    def _blind(self, name: str, age_s: float) -> Verdict:
        """A robot whose pose is old cannot be watched: it is held until it is seen again."""
        first = name not in self._unseen
        self._unseen.add(name)
        self._history.pop(name, None)
        reason = f"{name} is not watched: its pose on /tf is {age_s:.1f} s old, allowed {self._params.stale_s:g} s"
        return Verdict(Ahead(math.inf, "", False), True, first, reason)

    def _keep(
        self, hold: _Hold, now_s: float, name: str, seen: Seen, ahead: Ahead, moving: bool, fresh: bool
    ) -> Verdict:
        """A held robot is released when it stands and, if it has a new goal, that leads away."""
        if fresh and ahead.closing:
            return self._stop(now_s, name, seen, ahead)
        if ahead.closing and moving:
            hold.since_s = now_s
        elif not moving and (fresh or now_s - hold.since_s >= self._params.hold_s):
            del self._holds[name]
            return Verdict(ahead, False, False, "")
        return Verdict(ahead, True, fresh, hold.reason)

    def _stop(self, now_s: float, name: str, seen: Seen, ahead: Ahead) -> Verdict:
        step = "moving without a goal" if seen.target is None else _describe(seen.target)
        reason = f"{name} {step} would come within {ahead.distance_m:.3f} m of {ahead.nearest}"
        self._holds[name] = _Hold(now_s, reason, seen.goal_id)
        return Verdict(ahead, True, True, reason)

    def _measure(self, now_s: float, name: str, pose: Pose2) -> Motion:
        history = self._history.setdefault(name, deque())
        history.append((now_s, pose))
        while len(history) > 2 and now_s - history[1][0] >= self._params.window_s:
            history.popleft()
        return self._moved(name)

    def _moved(self, name: str) -> Motion:
        """Of a robot over the poses that are kept."""
        history = self._history.get(name)
        if not history or history[-1][0] <= history[0][0]:
            return Motion()
        (then_s, then), (now_s, pose) = history[0], history[-1]
        passed = now_s - then_s
        return Motion(
            (pose.x - then.x) / passed, (pose.y - then.y) / passed, wrap_angle(pose.yaw_rad - then.yaw_rad) / passed
        )


def _describe(target: Pose2) -> str:
    return f"on its step to ({target.x:.2f}, {target.y:.2f}, {math.degrees(target.yaw_rad):.0f} deg)"


def own_goals(tasks: Sequence[Tuple[str, str]]) -> Dict[str, Set[str]]:
    """Goals of each robot from (robot, goal) pairs: what it may touch."""
    owned: Dict[str, Set[str]] = {}
    for robot, goal in tasks:
        owned.setdefault(robot, set()).add(goal)
    return owned


def bodies_for(robot: str, bodies: Sequence[Body], allowed: Set[str]) -> List[Body]:
    """Everything but the robot itself and what it may touch."""
    return [body for body in bodies if body.name != robot and body.name not in allowed]

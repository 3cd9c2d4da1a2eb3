"""``rosrun yarm sweep``: a mobile robot of the running cell drives over its whole floor, a cleaning round.

    roslaunch yarm full_system.launch scene:=3m &
    rosrun yarm sweep --robot ankurbot_1

What the robot is and what stands about is taken from ``object_registry`` and tf, the robot is driven by its action
``<robot>/move_robot``. Nobody else may send it goals meanwhile: the Commander stays in its standby. Nothing is looked
at on the way; other robots must stand still.

Exit code: 0 every cell that can be reached was gone over, 1 some were not, 2 no answer in time, 3 refused.
"""

from __future__ import annotations

import argparse
import math
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
import rospy
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from tf2_msgs.msg import TFMessage

from yarm.control.actions import MobileAction
from yarm.experiments.coursework.sweep_picture import draw_sweep
from yarm.geometry import FloatArray, GridSpec, IntArray, Pose2, quaternion_from_rpy, transform_matrix
from yarm.geometry.kinds import ObjectKind
from yarm.geometry.solids import Solid
from yarm.manipulation.coverage.sweep import MARGIN_M, RobotSpace, SweepError, SweepPlan, named_cells, plan_sweep
from yarm.msg import MoveRobotAction, MoveRobotGoal, ObjectRegistry, RegisteredObject
from yarm.ros.common import names
from yarm.ros.common.checks import Doorkeeper, registry_fault, transform_fault
from yarm.ros.common.conversions import matrix_of_transform, pose2_of_transform, pose_message
from yarm.ros.common.solids import solids_of
from yarm.ros.common.start import init_command

DONE, LEFT_OUT, NO_ANSWER, REFUSED = 0, 1, 2, 3
CELL_M = 0.5
KNOWN_LIMIT_S = 60.0
"""Wall time in which registry and poses must come, s."""
GOAL_LIMIT_S = 120.0
"""Simulated time that one straight piece may take, s."""


@dataclass(frozen=True, eq=False)
class SweepReport:
    """How a round went.

    Attributes:
        plan: what was planned.
        track: (n, 2), metres, where the body's middle was.
        reason: why it ended early; empty when it did not.
    """

    plan: SweepPlan
    track: FloatArray
    reason: str

    @property
    def left_out(self) -> IntArray:
        """Reachable cells (n, 2) that were not gone over."""
        wanted = np.zeros(self.plan.floor.free.shape, dtype=bool)
        wanted[tuple(self.plan.coverage.cells.T)] = True
        return np.argwhere(wanted & ~self.plan.gone_over(self.track))


class CellView:
    """What the cell tells: who is in it, and where its frames are."""

    def __init__(self, robot: str) -> None:
        """Listen."""
        self._robot = robot
        self._changed = threading.Condition()
        self._entries: Dict[str, RegisteredObject] = {}
        self._frames: Dict[str, FloatArray] = {}
        self._track: List[Tuple[float, float]] = []
        self._door, self._tf_door = Doorkeeper(names.OBJECT_REGISTRY), Doorkeeper("/tf")
        self._subscribers = [
            rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10),
            rospy.Subscriber("/tf_static", TFMessage, self._on_tf, queue_size=100),
            rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=100),
        ]

    def wait(self, limit_s: float = KNOWN_LIMIT_S) -> str:
        """Until all is known that a plan needs; what is missing when it does not come in time (wall s)."""
        with self._changed:
            self._changed.wait_for(lambda: not self._missing(), timeout=limit_s)
            missing = self._missing()
        return f"{missing} within {limit_s:g} s; is the cell running?" if missing else ""

    def robot(self) -> Tuple[Pose2, Pose2, List[Solid]]:
        """Pose of the body, of the end effector in the body's frame, and the robot's solids in the body's frame."""
        with self._changed:
            entry = self._entries[self._robot]
            body = self._body()
            flat = transform_matrix((body.x, body.y, 0.0), quaternion_from_rpy(0.0, 0.0, body.yaw_rad))
            seed = _flat(self._frames[entry.seed_frame])
            solids = [solid.seen_from(np.linalg.inv(flat)) for solid in self._solids(entry)]
        return body, body.inverse().compose(seed), solids

    def things(self) -> List[Solid]:
        """Solids of everything else, world; debris lies on tables and is no obstacle to what is driven round them."""
        with self._changed:
            others = [entry for name, entry in self._entries.items() if name != self._robot]
            return [solid for entry in others for solid in self._solids(entry)]

    def track(self) -> FloatArray:
        """Where the body's middle was so far (n, 2), metres."""
        with self._changed:
            return np.array(self._track).reshape(-1, 2)

    def _missing(self) -> str:
        if not self._entries:
            return f"nothing came on {names.OBJECT_REGISTRY}"
        entry = self._entries.get(self._robot)
        if entry is None:
            there = ", ".join(name for name, e in self._entries.items() if e.object == ObjectKind.MOBILE) or "none"
            return f"no robot {self._robot} was registered (mobile robots: {there})"
        wanted = {entry.seed_frame, names.base_frame(self._robot)}
        wanted |= {frame for each in self._entries.values() for frame, _ in solids_of(each)}
        unknown = sorted(wanted - self._frames.keys())
        return f"no tf came of {', '.join(unknown)}" if unknown else ""

    def _solids(self, entry: RegisteredObject) -> List[Solid]:
        return [solid.seen_from(self._frames[frame]) for frame, solid in solids_of(entry)]

    def _body(self) -> Pose2:
        return _flat(self._frames[names.base_frame(self._robot)])

    def _on_registry(self, message: ObjectRegistry) -> None:
        if self._door.refuses(message, registry_fault(message)):
            return
        with self._changed:
            self._entries = {entry.name: entry for entry in message.entries}
            self._changed.notify_all()

    def _on_tf(self, message: TFMessage) -> None:
        with self._changed:
            for transform in message.transforms:
                if transform.header.frame_id.lstrip("/") != names.WORLD_FRAME:
                    continue
                if self._tf_door.refuses(message, transform_fault(transform, math.inf)):
                    continue
                child = transform.child_frame_id.lstrip("/")
                self._frames[child] = matrix_of_transform(transform.transform)
                if child == names.base_frame(self._robot):
                    place = pose2_of_transform(transform.transform)
                    self._track.append((place.x, place.y))
            self._changed.notify_all()


def sweep(view: CellView, plan: SweepPlan, reach: Pose2, drive: Callable[[Pose2], str]) -> SweepReport:
    """Drive a round.

    Args:
        view: of the cell.
        plan: the round.
        reach: the end effector in the body's frame.
        drive: brings the end effector to a pose, world; why it did not.
    """
    start = view.robot()[0]
    turned = [Pose2(start.x, start.y, plan.heading_rad)]
    reason = ""
    for number, stop in enumerate([*turned, *plan.stops]):
        reason = drive(stop.compose(reach))
        if reason:
            reason = f"at stop {number} of {len(plan.stops)}: {reason}"
            break
    return SweepReport(plan, view.track(), reason)


def move_goal(target: Pose2) -> MoveRobotGoal:
    """Goal that brings the end effector to a pose, turning about the body."""
    pose = pose_message(target.x, target.y, 0.0, target.yaw_rad)
    return MoveRobotGoal(target=pose, action=MobileAction.ABOUT_BODY.value)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """The command."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--robot", default="ankurbot_1", help="mobile robot that drives")
    options.add_argument("--half", type=float, default=GridSpec().upper[0], help="half the floor's side, m")
    options.add_argument("--cell", type=float, default=CELL_M, help="size of a cell, m; the body is 0.7 m wide")
    options.add_argument("--margin", type=float, default=MARGIN_M, help="distance kept to everything, m")
    options.add_argument("--heading", type=float, help="heading to keep, deg (default: the one that covers most)")
    options.add_argument("--results", type=Path, default=Path("results"), help="folder for sweep.png")
    chosen = options.parse_args(rospy.myargv(arguments)[1:] if arguments is None else arguments)
    init_command("sweep")
    view = CellView(chosen.robot)
    missing = view.wait()
    if missing:
        return _ended(NO_ANSWER, missing)
    body, reach, solids = view.robot()
    space = RobotSpace(solids, view.things(), chosen.margin)
    heading = None if chosen.heading is None else math.radians(chosen.heading)
    try:
        plan = plan_sweep(space, body, chosen.half, chosen.cell, heading)
    except SweepError as error:
        return _ended(REFUSED, str(error))
    _say(summary(plan))
    client = SimpleActionClient(names.move_robot(chosen.robot), MoveRobotAction)
    if not client.wait_for_server(rospy.Duration.from_sec(KNOWN_LIMIT_S)):
        return _ended(NO_ANSWER, f"{names.move_robot(chosen.robot)} has no server: is the controls server running?")
    report = sweep(view, plan, reach, lambda target: _drive(client, target))
    picture = draw_sweep(plan, report.track, view.things(), chosen.results / "sweep.png")
    left = report.left_out
    wanted = len({tuple(cell) for cell in plan.coverage.cells.tolist()})
    _say(f"{len(left)} of {wanted} cells left out: {named_cells(plan.floor, left)}; {picture}")
    return _ended(LEFT_OUT, report.reason) if report.reason else (LEFT_OUT if len(left) else DONE)


def summary(plan: SweepPlan) -> str:
    """The round in one line."""
    found = plan.coverage
    return (
        f"heading {math.degrees(plan.heading_rad):.0f} deg: {len(found.round)} cells in a closed round, "
        f"{len(found.loose)} after it, {len(plan.stops)} stops, {len(found.unreachable)} out of reach: "
        f"{named_cells(plan.floor, found.unreachable)}"
    )


def _drive(client: SimpleActionClient, target: Pose2) -> str:
    client.send_goal(move_goal(target))
    if not client.wait_for_result(rospy.Duration.from_sec(GOAL_LIMIT_S)):
        client.cancel_goal()
        return f"no end of the motion in {GOAL_LIMIT_S:g} s"
    return "" if client.get_state() == GoalStatus.SUCCEEDED else str(client.get_result().message)


def _flat(pose: FloatArray) -> Pose2:
    return Pose2(float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0]))


def _ended(code: int, reason: str) -> int:
    sys.stderr.write(f"sweep: {reason}\n")
    return code


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()

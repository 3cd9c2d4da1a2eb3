"""What the explorer says: status, events, commands, the map with its marks, and pictures for RViz."""

from __future__ import annotations

from typing import List, Optional, Sequence

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Path

from yarm.exploration.deadline import Lease
from yarm.exploration.model import Event, Observation
from yarm.exploration.session import RUNNING, SessionStep
from yarm.exploration.watch import Complaint
from yarm.geometry import FloatArray, Pose2
from yarm.msg import ExplorerEvent, ExplorerStatus, StepAck
from yarm.navigation.grid_map import GridMap
from yarm.ros.commander.reports import exact_time
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.conversions import pose_message
from yarm.ros.common.pictures import Picture
from yarm.ros.exploration.drawing import bump_markers, frontier_markers, view_markers
from yarm.ros.exploration.driving import DrivesByMoveBase, DrivesItself, Driving, twist_of
from yarm.ros.exploration.params import MOVE_BASE, ExplorerParams
from yarm.ros.exploration.progress import status_line
from yarm.ros.navigation.maps import grid_message

PROGRESS_S = 1.0
"""Between two lines of how a run goes."""
MAP_PERIOD_S = 1.0
"""Least time between two maps on ``~map``."""
PICTURE_PERIOD_S = 0.5
TRAIL_STEP_M = 0.05
TRAIL_LENGTH = 4000


class ExplorerOutputs:
    """Publishers; called from the loop alone."""

    def __init__(self, params: ExplorerParams) -> None:
        """Advertise everything."""
        self._params = params
        frame, advertise = params.map_frame, rospy.Publisher
        self._status = advertise("~status", ExplorerStatus, queue_size=10, latch=True, tcp_nodelay=True)
        self._events = advertise("~events", ExplorerEvent, queue_size=1000)
        self._driving: Driving = DrivesByMoveBase(frame) if params.drive == MOVE_BASE else DrivesItself()
        self._map = advertise("~map", OccupancyGrid, queue_size=1, latch=True)
        self._plan = advertise("~plan", Path, queue_size=2, latch=True)
        self._path = advertise("~path", Path, queue_size=2, latch=True)
        self._ack = advertise(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._frontiers, self._bumps = Picture("~frontiers", frame), Picture("~bumps", frame)
        self._view = Picture("~view", frame)
        self.forget()

    def forget(self) -> None:
        """Time went backwards, or a run begins: nothing drawn, nothing counted."""
        self._sent = 0
        self._driving.forget()
        self._map_count, self._map_s, self._picture_s = -1, -1.0, -1.0
        self._told_s = 0.0
        self._trail: List[Pose2] = []
        self._places: List[Pose2] = []
        self._took_ms = 0.0

    def connected(self) -> bool:
        """Somebody hears the commands and the acknowledgements."""
        return self._driving.connected() and int(self._ack.get_num_connections()) > 0

    def command(self, step: SessionStep, now_s: float) -> None:
        """What the base is told, or its navigation."""
        self._sent += self._driving.drive(step, now_s)

    def took(self, ms: float) -> None:
        """What a pass took, ms of the loop's processor time: without what it waited for."""
        self._took_ms = ms

    def acknowledge(self, now_s: float) -> None:
        """Lock-step: this pass is done."""
        if self._params.sync:
            self._ack.publish(step_ack(exact_time(now_s), self._sent))

    def status(
        self, step: SessionStep, lease: Lease, here: Optional[Pose2], saved: str, complaints: Sequence[Complaint]
    ) -> None:
        """The status, and what happened at this pass.

        Args:
            step: what the session decided.
            lease: what the gate goes by.
            here: where the robot is in the map, if that is known.
            saved: file of the map saved last.
            complaints: of the session, and of what is heard.
        """
        message = ExplorerStatus(
            state=step.state.value,
            behaviour=step.behaviour,
            moving=lease.moving,
            started=exact_time(lease.started_s),
            deadline=exact_time(lease.deadline_s),
            elapsed=step.elapsed_s,
            left=step.left_s,
            known_m2=step.known_m2,
            travelled=step.travelled_m,
            bumps=step.bumps,
            has_goal=step.intent.goal is not None,
            reason=step.reason,
            sensors=[complaint.text for complaint in complaints],
            saved=saved,
            has_pose=here is not None,
            pass_ms=self._took_ms,
        )
        message.header.stamp, message.header.frame_id = exact_time(lease.stamp_s), self._params.map_frame
        if step.intent.goal is not None:
            goal = step.intent.goal
            message.goal = pose_message(goal.x, goal.y, 0.0, goal.yaw_rad)
        if here is not None:
            message.pose = pose_message(here.x, here.y, 0.0, here.yaw_rad)
        message.command = twist_of(step.command)
        self._status.publish(message)
        for event in step.events:
            self._events.publish(self._event(event, lease.stamp_s))
        if self._params.progress and step.state in RUNNING and abs(step.elapsed_s - self._told_s) >= PROGRESS_S:
            self._told_s = step.elapsed_s
            rospy.loginfo("%s", status_line(message))

    def pictures(self, now_s: float, step: SessionStep, seen: Observation, grid: Optional[GridMap], count: int) -> None:
        """The map when it has changed, everything else twice a second."""
        due = now_s - self._map_s >= MAP_PERIOD_S or any(event.kind == "state" for event in step.events)
        if grid is not None and count != self._map_count and due:
            self._map_count, self._map_s = count, now_s
            self._map.publish(grid_message(grid, self._params.map_frame, exact_time(now_s)))
        if not self._params.visualize or seen.pose is None:
            return
        self._remember(step, seen.pose)
        if now_s - self._picture_s < PICTURE_PERIOD_S:
            return
        self._picture_s = now_s
        self._frontiers.send(frontier_markers(step.intent.frontiers), now_s)
        self._bumps.send(bump_markers(self._places), now_s)
        self._view.send(view_markers(step, self._params.base_frame), now_s)
        way = step.intent.path
        self._plan.publish(self._path_message(now_s, np.zeros((0, 2)) if way is None else way))
        self._path.publish(self._path_message(now_s, np.array([(p.x, p.y) for p in self._trail]).reshape(-1, 2)))

    def _remember(self, step: SessionStep, here: Pose2) -> None:
        if not self._trail or self._trail[-1].distance(here) >= TRAIL_STEP_M:
            self._trail = [*self._trail[-TRAIL_LENGTH:], here]
        if any(event.kind == "bump" for event in step.events):
            self._places.append(here)

    def _event(self, event: Event, stamp_s: float) -> ExplorerEvent:
        details = [(name, f"{value:.6g}" if isinstance(value, float) else str(value)) for name, value in event.details]
        message = ExplorerEvent(t=event.t_s, kind=event.kind)
        message.names, message.values = [name for name, _ in details], [value for _, value in details]
        message.header.stamp, message.header.frame_id = exact_time(stamp_s), self._params.map_frame
        return message

    def _path_message(self, now_s: float, way: FloatArray) -> Path:
        message = Path()
        message.header.stamp, message.header.frame_id = exact_time(now_s), self._params.map_frame
        for x, y in way:
            pose = PoseStamped(pose=pose_message(float(x), float(y), 0.0, 0.0))
            pose.header = message.header
            message.poses.append(pose)
        return message

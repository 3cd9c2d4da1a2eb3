"""What a robot type must offer to the controls server, and which type a robot's name means.

A new type is a new subclass of ``RobotUnit``, and a pattern of names that it is registered for (``register_robot_type``
of ``yarm.ros.controls.node``); docs/extending.md shows one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Callable, Optional, Tuple

import rospy

from yarm.control.base.controller import Outcome
from yarm.geometry.grid import FloatArray
from yarm.msg import MoveRobotFeedback, MoveRobotGoal, RegisteredObject
from yarm.ros.controls.params import ControlsServerParams

End = Tuple[Outcome, str]


@dataclass(frozen=True, eq=False)
class SeedPose:
    """Pose of a robot's seed in the world: metres, quaternion (x, y, z, w), time of the reading, s."""

    position: FloatArray
    quaternion: FloatArray
    stamp_s: float


class Outbox:
    """Publishers towards one receiver, which count what has gone out to a connected subscriber."""

    def __init__(self) -> None:
        """Nothing sent yet."""
        self.sent = 0
        self._publishers: list[rospy.Publisher] = []

    def publisher(self, topic: str, message_type: Any) -> rospy.Publisher:
        """Advertise a topic whose messages are counted by ``send``."""
        publisher = rospy.Publisher(topic, message_type, queue_size=100, tcp_nodelay=True)
        self._publishers.append(publisher)
        return publisher

    def send(self, publisher: rospy.Publisher, message: Any) -> None:
        """Publish; without a subscriber the message is lost and does not count."""
        if publisher.get_num_connections() > 0:
            self.sent += 1
            publisher.publish(message)

    @property
    def connected(self) -> bool:
        """Whether every topic has a subscriber."""
        return all(p.get_num_connections() > 0 for p in self._publishers)

    def close(self) -> None:
        """Withdraw all topics."""
        for publisher in self._publishers:
            publisher.unregister()


class RobotUnit(ABC):
    """One robot, driven by the server's tick. Methods are called from one thread."""

    kind = ""

    @abstractmethod
    def refusal(self, goal: MoveRobotGoal) -> str:
        """Why a goal cannot be taken, naming value and expectation; empty when it can."""

    def drives(self, goal: MoveRobotGoal) -> bool:
        """Whether a goal makes this node move something by itself, so that its watchers must be heard meanwhile."""
        del goal
        return False

    def continues(self, goal: MoveRobotGoal) -> bool:
        """Whether a goal leads on from the one under way, so that nothing needs to stop for it."""
        del goal
        return False

    @abstractmethod
    def start(self, goal: MoveRobotGoal) -> None:
        """Begin a goal that was not refused."""

    @abstractmethod
    def cancel(self, reason: str) -> None:
        """Give the goal up; the robot stands still at once."""

    @abstractmethod
    def tick(self, pose: SeedPose, now_s: float) -> Optional[End]:
        """Act on the newest pose; the end of the goal when it has come."""

    @abstractmethod
    def hold(self) -> None:
        """The pose is old: stand still, keep the goal."""

    @abstractmethod
    def feedback(self, feedback: MoveRobotFeedback) -> None:
        """Fill in the velocities."""

    @abstractmethod
    def ready(self, stamp_s: float) -> bool:
        """Lock-step: whether everything that belongs to a tick has come."""

    @abstractmethod
    def reset(self) -> None:
        """Simulated time went backwards: forget goal, stamps and counts."""

    @abstractmethod
    def close(self) -> None:
        """Withdraw all topics."""

    @property
    def simulator_commands(self) -> int:
        """Messages sent to the simulator so far."""
        return 0

    def acknowledge(self, stamp_s: float) -> None:
        """Lock-step: the tick is done; tell whoever else waits for this robot's commands (nobody, usually)."""
        del stamp_s


UnitFactory = Callable[
    [str, ControlsServerParams, Callable[[str], Optional[RegisteredObject]], Callable[[], None]], RobotUnit
]
"""Makes a unit from the robot's name, the server's parameters, the object registry by name, and a function to be called
when something has come that a tick may wait for."""

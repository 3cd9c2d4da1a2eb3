"""A TurtleBot in a room as trials drive it, whatever moves it: full physics or exact contact of a disc."""

from __future__ import annotations

from typing import FrozenSet, Protocol, Sequence, Tuple

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.robots.turtlebot import Bumper, BumperEvent
from yarm.sim.scenes.arena import Arena
from yarm.sim.touches import Touch


class RoomRobot(Protocol):
    """``KinematicWorld`` and ``PhysicsWorld``; the same arena, seed and commands give the same world."""

    arena: Arena

    @property
    def time_s(self) -> float:
        """Since the start."""

    @property
    def truth(self) -> Pose2:
        """Where the base is, world."""

    @property
    def true_speed_mps(self) -> float:
        """Over the ground, in the last step."""

    @property
    def touches(self) -> Sequence[Touch]:
        """What it came into contact with, in order."""

    @property
    def pressed(self) -> FrozenSet[Bumper]:
        """Sectors of the bumper that are pressed."""

    def step(self, v_mps: float, w_radps: float, dt_s: float) -> None:
        """Command speed ahead and turning, + = left, and let a time pass."""

    def odometry(self) -> Odometry:
        """What wheels and gyro add up to; the frame is where the robot started."""

    def scan(self) -> Scan:
        """The laser scan from here, now."""

    def low_view(self) -> FloatArray:
        """(n, 2) what a depth image shows of obstacles below the scan, base frame, metres."""

    def take_bumps(self) -> Tuple[BumperEvent, ...]:
        """Changes of the bumper since the last call, in order."""

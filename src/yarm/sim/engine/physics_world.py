"""The room in full physics behind the interface of the kinematic world: as fast as the machine, without ROS."""

from __future__ import annotations

from typing import Callable, FrozenSet, Optional, Sequence, Tuple

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.robots import turtlebot
from yarm.robots.turtlebot import Bumper, BumperEvent
from yarm.sim.engine.room import TICK_S, RoomParams, RoomWorld
from yarm.sim.scenes.arena import Arena
from yarm.sim.sensors.noise import FloatImage
from yarm.sim.touches import Touch, TouchLog

FindLow = Callable[[FloatImage], FloatArray]
"""(n, 2) places of low obstacles in the base frame, metres, from a depth image (480, 640), metres."""


class PhysicsWorld:
    """A RoomRobot in PyBullet. Close it when done, or use it as a context manager.

    Attributes:
        arena: the room.
        true_speed_mps: over the ground, in the last step.
    """

    def __init__(self, arena: Arena, seed: int, find_low: FindLow, params: Optional[RoomParams] = None) -> None:
        """Put the robot at its start.

        Args:
            arena: the room.
            seed: of all noise.
            find_low: reads low obstacles off a depth image.
            params: how the room is simulated.
        """
        self.arena = arena
        self.true_speed_mps = 0.0
        self._room = RoomWorld(arena, params, seed)
        self._find_low = find_low
        self._log = TouchLog({block.name: block.size[2] for block in arena.blocks})
        self._log.moved(0.0, self.truth)

    def __enter__(self) -> PhysicsWorld:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the engine."""
        self._room.close()

    @property
    def time_s(self) -> float:
        """Since the start."""
        return self._room.time_s

    @property
    def truth(self) -> Pose2:
        """Where the base is, world."""
        return self._room.truth

    @property
    def touches(self) -> Sequence[Touch]:
        """What it came into contact with, in order."""
        return self._log.touches

    @property
    def pressed(self) -> FrozenSet[Bumper]:
        """Sectors of the bumper that are pressed."""
        return self._room.pressed

    def step(self, v_mps: float, w_radps: float, dt_s: float) -> None:
        """Command the wheels and let a time pass.

        Args:
            v_mps: speed ahead, cut to what the base can do.
            w_radps: turning, + = left; cut likewise.
            dt_s: a multiple of TICK_S.

        Raises:
            ValueError: it is none.
            CommandError: a speed is not finite.
        """
        ticks = round(dt_s / TICK_S)
        if ticks < 1 or abs(ticks * TICK_S - dt_s) > 1e-9:
            raise ValueError(f"a step of {dt_s:g} s is no multiple of physics' tick, {TICK_S:g} s")
        before = self.truth
        self._room.drive(v_mps, w_radps)
        for _ in range(ticks):
            self._room.tick()
            if self._room.odometry_due():
                self._feel()
        self.true_speed_mps = self.truth.distance(before) / dt_s

    def odometry(self) -> Odometry:
        """What wheels and gyro add up to; the frame is where the robot started."""
        return self._room.odometry

    def scan(self) -> Scan:
        """The laser scan from here, now."""
        return self._room.scan()

    def low_view(self) -> FloatArray:
        """(n, 2) what the depth image shows of obstacles below the scan, base frame, metres."""
        return self._find_low(self._room.depth())

    def take_bumps(self) -> Tuple[BumperEvent, ...]:
        """Changes of the bumper since the last call, in order."""
        return self._room.take_bumps()

    def _feel(self) -> None:
        """Note where the robot is and what it touches."""
        self._log.moved(self.time_s, self.truth)
        for contact in self._room.contacts.take():
            others = {contact.a.body, contact.b.body} - {turtlebot.TYPE, "floor"}
            if turtlebot.TYPE in (contact.a.body, contact.b.body) and others:
                self._log.contact(self.time_s, others.pop(), contact.point[0], contact.point[1])

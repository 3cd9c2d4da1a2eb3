"""A TurtleBot in an arena: it moves as a disc, touches, slips, and measures."""

from __future__ import annotations

import math
from typing import FrozenSet, List, Sequence, Set, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2, wrap_angle
from yarm.geometry.scans import Odometry, Scan
from yarm.robots.turtlebot import (
    RADIUS_M,
    SPEED_LIMIT_MPS,
    TURN_LIMIT_RADPS,
    Bumper,
    BumperEvent,
    bumper_at,
)
from yarm.sim.kinematic.depth_sensor import DepthSensor
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.kinematic.wheel_odometry import TYPICAL, OdometryNoise, WheelOdometry
from yarm.sim.scenes.arena import Arena
from yarm.sim.touches import Touch

TOUCH_M = 0.001
"""A gap up to this is a contact."""
APART_M = 0.01
"""A gap above this ends a touch; the next contact with the same block is a new one."""
STEP_M = 0.003
"""Farthest motion between two looks at the contacts."""
STEP_RAD = 0.05
AHEAD_RAD = math.radians(30.0)
"""A contact within this of the way stops the robot; farther aside it slides."""
PUSHES = 6
"""Most corrections of one motion; a robot that is still inside a block then stays where it was."""


Contact = Tuple[int, float, float]
"""Index of a block and the point of it that is touched, world, metres."""


class KinematicWorld:
    """One robot, one arena, time in steps; the same arena, seed and commands give the same world."""

    def __init__(self, arena: Arena, seed: int, noise: OdometryNoise = TYPICAL) -> None:
        """Put the robot at its start.

        Args:
            arena: the room.
            seed: of all noise.
            noise: of the odometry.

        Raises:
            ValueError: the robot stands in a block.
        """
        self.arena = arena
        self.boxes = FlatBoxes(arena.blocks)
        self.truth = arena.start
        self.true_speed_mps = 0.0
        self.touches: List[Touch] = []
        self._ticks_s = 0.0
        self._wheels = WheelOdometry(np.random.default_rng([seed, 1]), noise)
        self._sensor = DepthSensor(self.boxes, seed)
        contacts = self._contacts(self._near(TOUCH_M))
        for box, x, y in contacts:
            if math.hypot(x - self.truth.x, y - self.truth.y) < RADIUS_M - TOUCH_M:
                raise ValueError(f"arena {arena.name}: the robot starts inside {self.boxes.names[box]}")
        self._touching: Set[int] = {box for box, _, _ in contacts}
        self._pressed = self._sectors(contacts)
        self._events: List[BumperEvent] = []

    def __enter__(self) -> KinematicWorld:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing to free."""

    @property
    def time_s(self) -> float:
        """Since the start."""
        return self._ticks_s

    @property
    def pressed(self) -> FrozenSet[Bumper]:
        """Sectors of the bumper that are pressed."""
        return self._pressed

    def step(self, v_mps: float, w_radps: float, dt_s: float) -> None:
        """Drive for a time; what stands in the way stops the robot or turns it aside.

        Args:
            v_mps: speed of the wheels ahead; cut to what the base can do.
            w_radps: turning, + = left; cut likewise.
            dt_s: for how long, above 0.
        """
        v = min(max(v_mps, -SPEED_LIMIT_MPS), SPEED_LIMIT_MPS)
        w = min(max(w_radps, -TURN_LIMIT_RADPS), TURN_LIMIT_RADPS)
        way = abs(v) * dt_s
        near = self._near(way + APART_M)
        count = 1
        if near:
            count = max(1, math.ceil(way / STEP_M), math.ceil(abs(w) * dt_s / STEP_RAD))
        before = self.truth
        for _ in range(count):
            self._ticks_s += dt_s / count
            self._wheels.roll(v, w, dt_s / count, self._ticks_s)
            self._move(v, w, dt_s / count, near)
            if near or self._touching:
                self._feel(abs(v), near)
        self.true_speed_mps = self.truth.distance(before) / dt_s

    def odometry(self) -> Odometry:
        """What wheels and gyro add up to; the frame is where the robot started."""
        return self._wheels.now

    def scan(self) -> Scan:
        """The laser scan from here, now; each call draws its own noise."""
        return self._sensor.scan(self.truth, self._ticks_s)

    def low_view(self) -> FloatArray:
        """(n, 2) what a depth image shows of obstacles below the scan, base frame, metres."""
        return self._sensor.low_view(self.truth)

    def take_bumps(self) -> Tuple[BumperEvent, ...]:
        """Changes of the bumper since the last call, in order."""
        events = tuple(self._events)
        self._events.clear()
        return events

    def _near(self, reach_m: float) -> List[int]:
        return self.boxes.near(self.truth.x, self.truth.y, RADIUS_M + reach_m)

    def _move(self, v: float, w: float, dt_s: float, near: Sequence[int]) -> None:
        middle = self.truth.yaw_rad + 0.5 * w * dt_s
        x = self.truth.x + v * dt_s * math.cos(middle)
        y = self.truth.y + v * dt_s * math.sin(middle)
        yaw = wrap_angle(self.truth.yaw_rad + w * dt_s)
        if near:
            x, y = self._pushed_out(x, y, near, middle if v >= 0.0 else middle + math.pi)
        self.truth = Pose2(x, y, yaw)

    def _pushed_out(self, x: float, y: float, near: Sequence[int], heading: float) -> Tuple[float, float]:
        """The nearest place that is clear: aside of a block met aslant, back along the way from one that lies ahead."""
        for _ in range(PUSHES):
            depth, box = 0.0, -1
            for candidate in near:
                px, py = self.boxes.nearest_point(candidate, x, y)
                inside = RADIUS_M - math.hypot(px - x, py - y)
                if inside > max(depth, 1e-9):
                    depth, box = inside, candidate
            if box < 0:
                return x, y
            px, py = self.boxes.nearest_point(box, x, y)
            distance = math.hypot(px - x, py - y)
            if distance < 1e-6:
                break
            normal = math.atan2(py - y, px - x)
            bearing = wrap_angle(normal - heading)
            if abs(bearing) < AHEAD_RAD:
                normal, depth = heading, depth / math.cos(bearing)
            x -= depth * math.cos(normal)
            y -= depth * math.sin(normal)
        return self.truth.x, self.truth.y

    def _contacts(self, near: Sequence[int]) -> List[Contact]:
        """Blocks within touching distance."""
        found = []
        for box in near:
            x, y = self.boxes.nearest_point(box, self.truth.x, self.truth.y)
            if math.hypot(x - self.truth.x, y - self.truth.y) <= RADIUS_M + TOUCH_M:
                found.append((box, x, y))
        return found

    def _bearing(self, x: float, y: float) -> float:
        return wrap_angle(math.atan2(y - self.truth.y, x - self.truth.x) - self.truth.yaw_rad)

    def _sectors(self, contacts: Sequence[Contact]) -> FrozenSet[Bumper]:
        sectors = (bumper_at(self._bearing(x, y)) for _, x, y in contacts)
        return frozenset(sector for sector in sectors if sector is not None)

    def _feel(self, speed_mps: float, near: Sequence[int]) -> None:
        """Note what is touched and let go."""
        contacts = self._contacts(near)
        for box, x, y in contacts:
            if box not in self._touching:
                name, height = self.boxes.names[box], float(self.boxes.heights[box])
                self.touches.append(Touch(self._ticks_s, name, height, x, y, self._bearing(x, y), speed_mps))
                self._wheels.slip()
        kept = {box for box, _, _ in contacts} | {
            box for box in self._touching if box in near and self._gap(box) <= APART_M
        }
        self._touching = kept
        sectors = self._sectors(contacts)
        for sector in Bumper:
            if (sector in sectors) != (sector in self._pressed):
                self._events.append(BumperEvent(sector, sector in sectors))
        self._pressed = sectors

    def _gap(self, box: int) -> float:
        x, y = self.boxes.nearest_point(box, self.truth.x, self.truth.y)
        return math.hypot(x - self.truth.x, y - self.truth.y) - RADIUS_M

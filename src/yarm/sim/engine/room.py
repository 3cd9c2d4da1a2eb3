"""A flat room with a TurtleBot in it: physics, bumper, odometry, scan, depth camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, FrozenSet, List, Optional, Tuple

import numpy as np
import pybullet

from yarm.geometry import FloatArray, Pose2, quaternion_from_rpy, transform_matrix
from yarm.geometry.kinds import ObjectKind
from yarm.geometry.scans import Odometry, Scan
from yarm.geometry.solids import Shape
from yarm.geometry.urdf import LinkSolid
from yarm.params import param
from yarm.robots import turtlebot
from yarm.robots.turtlebot import Bumper, BumperEvent
from yarm.sim.engine.bodies import link_names, load_box, load_floor, open_engine
from yarm.sim.engine.contacts import FLOOR, ContactLog
from yarm.sim.kinematic.wheel_odometry import EXACT, TYPICAL, WheelOdometry
from yarm.sim.robots.bumper import BumperLogic
from yarm.sim.robots.turtlebot import TurtleBot
from yarm.sim.scenes.arena import Arena, Block, BlockKind
from yarm.sim.scenes.bodies import FramedSolid
from yarm.sim.sensors.noise import FloatImage
from yarm.sim.sensors.room_eye import RoomEye

STEPS_PER_SECOND = 200
STEPS_PER_TICK = 2
TICK_S = STEPS_PER_TICK / STEPS_PER_SECOND
TICKS_PER_ODOMETRY = round(1.0 / (turtlebot.ODOMETRY_RATE_HZ * TICK_S))
TICKS_PER_SCAN = round(1.0 / (turtlebot.SCAN_RATE_HZ * TICK_S))
COLOURS: Dict[BlockKind, Tuple[float, float, float]] = {
    BlockKind.WALL: (0.85, 0.87, 0.90),
    BlockKind.BLOCK: (0.55, 0.57, 0.60),
    BlockKind.LOW: (0.66, 0.26, 0.18),
    BlockKind.BOX: (0.70, 0.55, 0.38),
}
"""Red, green, blue of each kind of block."""


@dataclass(frozen=True)
class RoomParams:
    """How the room is simulated."""

    wheel_acceleration: float = param(
        turtlebot.ACCELERATION_MPS2, "m/s^2", "greatest change of a wheel's speed", low=0.1, high=5.0
    )
    sensor_noise: bool = param(True, "", "Kinect-like noise on depth and scan, single beams lost")
    odometry_noise: bool = param(True, "", "errors of wheels and gyro; off, odometry still slips")


class RoomWorld:
    """A PyBullet world without a window. Not thread-safe. Close it when done, or use it as a context manager.

    Attributes:
        arena: what it was made from.
        ticks: how many have passed.
        robot: the TurtleBot.
        contacts: who touches whom.
    """

    def __init__(self, arena: Arena, params: Optional[RoomParams] = None, seed: int = -1, gui: bool = False) -> None:
        """Build the arena, the robot at its start.

        Args:
            arena: walls, blocks, start.
            params: how it is simulated.
            seed: of all noise; -1 takes the arena's own.
            gui: PyBullet's window.
        """
        self.arena = arena
        self.params = params or RoomParams()
        self.ticks = 0
        self._client = open_engine(STEPS_PER_SECOND, gui)
        self.contacts = ContactLog(self._client, {})
        self.contacts.register(load_floor(self._client), "floor", FLOOR, ["floor"])
        solids = [self._add(block) for block in arena.blocks]
        self.robot = TurtleBot(self._client, arena.start)
        self.contacts.register(self.robot.uid, turtlebot.TYPE, ObjectKind.MOBILE, self.robot.links)
        drawn = arena.seed if seed < 0 else seed
        poses = np.array([solid.T_frame_solid for solid in solids]).reshape(-1, 4, 4)
        self._eye = RoomEye(solids, poses, drawn, self.params.sensor_noise)
        noise = TYPICAL if self.params.odometry_noise else EXACT
        self._odometry = WheelOdometry(np.random.default_rng([drawn, 1]), noise)
        self._bumper = BumperLogic()
        self._events: List[BumperEvent] = []
        self._rolled, self._yaw_rad = self.robot.rolled_m(), arena.start.yaw_rad

    def __enter__(self) -> RoomWorld:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the engine."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1

    @property
    def client(self) -> int:
        """PyBullet's number of this world, for tests that ask the engine itself."""
        return self._client

    @property
    def steps(self) -> int:
        """Physics steps since the start."""
        return self.ticks * STEPS_PER_TICK

    @property
    def pressed(self) -> FrozenSet[Bumper]:
        """Sectors of the bumper that are pressed now."""
        return self._bumper.pressed

    @property
    def time_ns(self) -> int:
        """Simulated time, nanoseconds."""
        return self.steps * 1_000_000_000 // STEPS_PER_SECOND

    @property
    def time_s(self) -> float:
        """Simulated time, s."""
        return self.ticks * TICK_S

    def drive(self, v_mps: float, w_radps: float) -> bool:
        """Command the base; it stops by itself COMMAND_TIMEOUT_S after the last command.

        Returns:
            true when a speed had to be clamped.

        Raises:
            CommandError: not finite.
        """
        return self.robot.drive(v_mps, w_radps, self.time_s)

    def tick(self) -> None:
        """One tick: motors, physics, bumper and odometry when they are due."""
        self.robot.update(self.time_s, TICK_S, self.params.wheel_acceleration)
        for _ in range(STEPS_PER_TICK):
            pybullet.stepSimulation(physicsClientId=self._client)
            self.robot.feel()
            self.contacts.collect()
        self.ticks += 1
        if self.odometry_due():
            self._events += self._bumper.look(self.robot.pressed())
            self._measure_motion()

    def run(self, seconds: float) -> None:
        """Tick for a simulated time, s."""
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def odometry_due(self) -> bool:
        """Whether odometry is new at this tick."""
        return self.ticks % TICKS_PER_ODOMETRY == 0

    def scan_due(self) -> bool:
        """Whether the depth camera takes an image at this tick."""
        return self.ticks % TICKS_PER_SCAN == 0

    @property
    def odometry(self) -> Odometry:
        """The newest odometry."""
        return self._odometry.now

    @property
    def truth(self) -> Pose2:
        """Where base_footprint is, world."""
        return self.robot.pose()

    def take_bumps(self) -> Tuple[BumperEvent, ...]:
        """Changes of the bumper since the last call, in order."""
        events, self._events = tuple(self._events), []
        return events

    def scan(self) -> Scan:
        """What the scan sees now."""
        return self._eye.scan(self.robot.base(), self.time_s, self.frame)

    def depth(self) -> FloatImage:
        """What the depth camera sees now: (480, 640), metres, NaN where nothing is measured."""
        return self._eye.depth(self.robot.base(), self.frame)

    @property
    def frame(self) -> int:
        """Number of the newest scan that was due."""
        return self.ticks // TICKS_PER_SCAN

    def _add(self, block: Block) -> FramedSolid:
        """Put a block on the floor."""
        place = (block.pose.x, block.pose.y, 0.5 * block.size[2])
        uid = load_box(self._client, block.size, place, block.pose.yaw_rad)
        self.contacts.register(uid, block.name, ObjectKind.OBSTACLE, link_names(self._client, uid))
        pose: FloatArray = transform_matrix(place, quaternion_from_rpy(0.0, 0.0, block.pose.yaw_rad))
        solid = LinkSolid(Shape.BOX, block.size, np.eye(4), block.name, COLOURS[block.kind])
        return FramedSolid(block.name, solid, pose)

    def _measure_motion(self) -> None:
        rolled, yaw_rad = self.robot.rolled_m(), self.robot.pose().yaw_rad
        way_m = float(np.mean(rolled - self._rolled))
        turn_rad = float(np.remainder(yaw_rad - self._yaw_rad + np.pi, 2.0 * np.pi) - np.pi)
        dt_s = TICKS_PER_ODOMETRY * TICK_S
        self._odometry.roll(way_m / dt_s, turn_rad / dt_s, dt_s, self.time_s)
        self._rolled, self._yaw_rad = rolled, yaw_rad

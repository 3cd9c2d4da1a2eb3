"""A mission played in physics, judged by ground truth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix
from yarm.manipulation.clearing.mission import Command, FloorMission, PieceReport, Reading
from yarm.manipulation.motion.trajectory import Trajectory
from yarm.sim.engine.youbot_floor import STEPS_PER_SECOND, YoubotFloor

STEPS_PER_TICK = 4
"""The mission is asked once in so many physics steps: 60 times a second."""
SEEN_M, SEEN_RAD = 0.003, math.radians(1.5)
"""Greatest error with which a piece is seen along each axis, and of its heading."""
LIMIT_S = 900.0


@dataclass(frozen=True, eq=False)
class FloorPlayed:
    """What came of a mission, by ground truth.

    Attributes:
        pieces: as the mission says.
        in_bin: which pieces lie in the bin.
        wrong: touches that nobody may.
        press_n: greatest force of the cup on anything at any time, N.
        lost: pieces torn off the cup.
        duration_s: simulated.
        track: (m, 3) the base's way, metres and rad.
        reason: why it was broken off; empty when it ended by itself.
    """

    pieces: Dict[str, PieceReport]
    in_bin: Dict[str, bool]
    wrong: Tuple[str, ...]
    press_n: float
    lost: int
    duration_s: float
    track: FloatArray
    reason: str = ""

    @property
    def faults(self) -> List[str]:
        """What is not as it must be."""
        found = [
            f"{name}: {self.pieces[name].reason or 'not in the bin'}"
            for name, there in self.in_bin.items()
            if not there
        ]
        found += [f"touched: {touch}" for touch in self.wrong]
        return [*found, self.reason] if self.reason else found


class FloorRobot:
    """Eyes and hands of a mission in a world."""

    def __init__(self, world: YoubotFloor, seed: int) -> None:
        """Take the robot.

        Args:
            world: its floor.
            seed: of the errors with which it sees.
        """
        self._world, self._rng = world, np.random.default_rng((seed, 1))
        self._samples: Optional[Tuple[FloatArray, FloatArray]] = None
        self._at, self._lost_s = 0.0, 0.0
        self.press_n = 0.0

    @property
    def set_points(self) -> FloatArray:
        """Joints (5,), rad, where the arm's motion is now; without one where they are measured."""
        return self._world.robot.joints() if self._samples is None else self._sample()[0]

    @property
    def left_s(self) -> float:
        """How much of the arm's motion is left, s."""
        return 0.0 if self._samples is None else max(len(self._samples[0]) - self._at, 0.0) / STEPS_PER_SECOND

    def read(self) -> Reading:
        """What the robot knows now."""
        robot = self._world.robot
        pieces = {piece.name: self._seen(piece.name) for piece in self._world.scene.debris}
        force = max(robot.cup.press_n().values(), default=0.0)
        now_s = self._world.time_s - self._lost_s
        return Reading(now_s, robot.pose(), robot.joints(), robot.cup.grasping, force, pieces)

    def tell(self, command: Command, rate: float = 1.0) -> None:
        """Do as told, and let a tick pass.

        Args:
            command: what is told.
            rate: how fast base, arm and the robot's own clock go, 0 to 1: less under ``Brake``.
        """
        robot = self._world.robot
        robot.drive(rate * command.velocity)
        if command.suction is not None:
            (robot.cup.on if command.suction else robot.cup.off)()
        if command.motion is not None:
            self._samples, self._at = _sampled(command.motion), 0.0
        for _ in range(STEPS_PER_TICK):
            if self._samples is not None:
                q, speed = self._sample()
                robot.follow(q, rate * speed)
                self._at += rate
            self._world.step()
            self._lost_s += (1.0 - rate) / STEPS_PER_SECOND
            self.press_n = max([self.press_n, *robot.cup.press_n().values()])

    def _sample(self) -> Tuple[FloatArray, FloatArray]:
        """Joints and speeds, (5,) each, where the motion is now."""
        assert self._samples is not None
        index = min(int(self._at), len(self._samples[0]) - 1)
        return self._samples[0][index], self._samples[1][index]

    def _seen(self, name: str) -> FloatArray:
        x, y, z = self._rng.uniform(-SEEN_M, SEEN_M, 3)
        turn = self._rng.uniform(-SEEN_RAD, SEEN_RAD)
        pose = self._world.piece(name)
        error = transform_matrix((0.0, 0.0, 0.0), quaternion_from_rpy(0.0, 0.0, turn))
        seen = np.asarray(pose @ error)
        seen[:3, 3] += (x, y, z)
        return seen


Watch = Callable[[YoubotFloor, Command], None]
"""What looks on: it is given the world after each tick, and what the robot was told."""


def unwatched(world: YoubotFloor, command: Command) -> None:
    """Nobody looks."""


def play_mission(
    world: YoubotFloor,
    mission: FloorMission,
    robot: FloorRobot,
    limit_s: float = LIMIT_S,
    watch: Watch = unwatched,
) -> FloorPlayed:
    """Play a mission to its end.

    Args:
        world: the floor, the arm as the mission carries.
        mission: what is to be done.
        robot: eyes and hands there.
        limit_s: simulated time after which it is broken off.
        watch: looks on.

    Raises:
        MissionError: it cannot begin.
    """
    work = mission.work(robot.read())
    track = []
    reason = f"not done within {limit_s:g} s"
    try:
        command = next(work)
        while world.time_s < limit_s:
            robot.tell(command)
            watch(world, command)
            reading = robot.read()
            track.append((reading.base.x, reading.base.y, reading.base.yaw_rad))
            command = work.send(reading)
    except StopIteration:
        reason = ""
    in_bin = {name: world.in_bin(name) for name in mission.pieces}
    return FloorPlayed(
        mission.pieces,
        in_bin,
        tuple(world.wrong_touches()),
        robot.press_n,
        world.robot.cup.lost,
        world.time_s,
        np.array(track),
        reason,
    )


def _sampled(motion: Trajectory) -> Tuple[FloatArray, FloatArray]:
    times = np.arange(1, math.ceil(motion.duration_s * STEPS_PER_SECOND) + 1) / STEPS_PER_SECOND
    q, speed, _ = motion.evaluate(np.minimum(np.append(times, motion.duration_s), motion.duration_s))
    speed[-1] = 0.0
    return q, speed

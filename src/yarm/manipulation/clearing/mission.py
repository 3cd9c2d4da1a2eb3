"""Clearing the floor: piece after piece is gone to, picked up, carried to the bin and let go; what fails is tried anew.

The mission is a coroutine: it takes what the robot reads, and gives what the robot is told, once a tick. It knows the
floor's scene (bin, obstacles, weights) and sees where the pieces lie; it knows no world, no clock and no threads.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Dict, Generator, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2, transform_points
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.clearing.arm_work import (
    DROP_TILTS,
    LIFT_M,
    LOAD_M,
    OVER_RIM_M,
    PIECE_M,
    ArmWork,
    PickPlan,
    WorkError,
    carry_joints,
    grip_point,
    load_bottom_m,
)
from yarm.manipulation.clearing.driving import Follower
from yarm.manipulation.clearing.floor_space import MARGIN_M, FloorSpace, Standing, standing
from yarm.manipulation.clearing.reachability import reach_map
from yarm.manipulation.clearing.stands import Stand, choose_stand
from yarm.manipulation.motion.trajectory import Trajectory, arm_limits, quintic
from yarm.sim.robots.suction import HOLDING_N
from yarm.sim.scenes.youbot_floor import HALF_M, FloorScene

GRAVITY_MPS2 = 9.81
PAYLOAD_KG = 0.5
"""What the arm carries, by its maker."""
TRIES = 3
MOST_PRESS_N = 10.0
"""The cup pushes no harder for long on something that it does not hold."""
STAND_MARGIN_M = MARGIN_M + 0.01
"""A stand keeps a little more than a way does, as the base does not stop on the spot."""
SETTLE_S = 0.15
LET_GO_S = 0.8
DROP_ASIDE_M = (0.0, -0.07, 0.07)
"""Pieces are let go so far beside the bin's middle, one after the other."""


@dataclass(frozen=True, eq=False)
class Reading:
    """What the robot knows at a tick.

    Attributes:
        time_s: now.
        base: where its middle stands, world.
        joints: (5,), rad.
        grasping: whether something hangs on the cup.
        press_n: force on the cup, N.
        pieces: T_world_piece (4, 4) of every piece as it is seen.
    """

    time_s: float
    base: Pose2
    joints: FloatArray
    grasping: bool
    press_n: float
    pieces: Mapping[str, FloatArray]


@dataclass(frozen=True, eq=False)
class Command:
    """What the robot is told: base velocity (3,), a motion that begins now (None: go on), suction (None: leave it)."""

    velocity: FloatArray = field(default_factory=lambda: np.zeros(3))
    motion: Optional[Trajectory] = None
    suction: Optional[bool] = None


@dataclass
class PieceReport:
    """What came of one piece.

    Attributes:
        cleared: seen in the bin after it was let go.
        tries: picks that were begun.
        reason: why it is not cleared, or why a try failed.
        press_n: greatest force of the cup at each pick, N.
        stands: where the base stood for it, pick and drop.
    """

    cleared: bool = False
    tries: int = 0
    reason: str = ""
    press_n: List[float] = field(default_factory=list)
    stands: List[Pose2] = field(default_factory=list)


class MissionError(ValueError):
    """The mission cannot begin; the message says why."""


class _TryError(Exception):
    """A try has failed; the message says why."""


Work = Generator[Command, Reading, None]


class FloorMission:
    """Clears a floor. Run ``work``; ``pieces`` says what came of it."""

    def __init__(
        self,
        scene: FloorScene,
        names: Optional[Sequence[str]] = None,
        seed: int = 0,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Look at the scene.

        Args:
            scene: where bin and obstacles stand, and how heavy the pieces are.
            names: of the pieces to clear; None for all.
            seed: of the arm's planner.
            say: is told what is done.

        Raises:
            MissionError: a name that is not in the scene, or the arm cannot carry over the bin's rim.
        """
        known = [piece.name for piece in scene.debris]
        unknown = [name for name in names or () if name not in known]
        if unknown:
            raise MissionError(f"no debris is called {', '.join(unknown)}; there are {', '.join(known) or 'none'}")
        self._scene, self._seed, self._say = scene, seed, say
        try:
            self.carry = np.array(carry_joints(scene.bin.size[2]))
        except WorkError as error:
            raise MissionError(str(error)) from error
        self._under_arm_m = load_bottom_m(self.carry) - 0.5 * OVER_RIM_M
        self.pieces: Dict[str, PieceReport] = {name: PieceReport() for name in names or known}
        self._now: Reading
        self._set = self.carry

    def work(self, first: Reading) -> Work:
        """Clear piece after piece, always the nearest; ends when each is cleared or given up.

        Raises:
            MissionError: the base stands where nothing can begin.
        """
        self._now = first
        blocked = self._space().in_the_way(first.base)
        if blocked:
            raise MissionError(f"at the start {blocked}")
        for piece in self._scene.debris:
            if piece.name in self.pieces:
                self.pieces[piece.name].reason = weight_fault(piece.name, piece.mass_kg)
        left = [name for name, report in self.pieces.items() if not report.reason]
        while left:
            name = min(left, key=self._distance)
            left.remove(name)
            yield from self._clear(name)
        yield Command(np.zeros(3))

    def _clear(self, name: str) -> Work:
        report = self.pieces[name]
        while report.tries < TRIES and not report.cleared:
            report.tries, report.reason = report.tries + 1, ""
            try:
                yield from self._pick(name, report)
                yield from self._bring(name, report)
                report.cleared, report.reason = True, ""
                self._tell(f"{name} is in the bin")
            except (_TryError, WorkError) as error:
                report.reason = str(error)
                self._tell(f"{name}, try {report.tries}: {error}")
                yield from self._recovered()

    def _pick(self, name: str, report: PieceReport) -> Work:
        seen = self._now.pieces[name]
        grip = grip_point(seen)
        self._tell(f"{name} is seen at ({grip[0]:.2f}, {grip[1]:.2f})")
        stand = self._stand(
            grip[None, :2],
            round(PIECE_M[2], 2),
            LIFT_M,
            lambda base: self._arm(base, name).pick(self.carry, seen),
        )
        report.stands.append(stand.pose)
        yield from self._drive(stand.way, False)
        arm = self._arm(self._now.base, name)
        plan = arm.pick(self._set, self._now.pieces[name])
        yield from self._play((*plan.reach, plan.descend), False)
        yield from self._feel(plan, report)
        yield from self._play((arm.lift(self._set, plan.above),), False)
        if not self._now.grasping:
            torn = f"it was torn off the cup while it was lifted: the cup holds {HOLDING_N:g} N"
            raise _TryError(report.reason or torn)
        yield from self._play(arm.carry(self._set, self.carry, True), True)

    def _feel(self, plan: PickPlan, report: PieceReport) -> Work:
        """Down until the cup has the piece, or pushes on what it does not hold, or the way ends."""
        self._now = yield Command(motion=plan.feel, suction=True)
        ended = self._now.time_s + plan.feel.duration_s + SETTLE_S
        most = 0.0
        while self._now.time_s < ended and not self._now.grasping and self._now.press_n < MOST_PRESS_N:
            self._now = yield Command()
            most = max(most, self._now.press_n)
        met = self._now.press_n >= MOST_PRESS_N
        yield from self._hold()
        report.press_n.append(max(most, self._now.press_n))
        if not self._now.grasping:
            report.reason = (
                f"what was met with {most:.0f} N is not held" if met else "nothing was met where the piece was seen"
            )

    def _bring(self, name: str, report: PieceReport) -> Work:
        places = self._drop_places()
        stand = self._stand(
            places[:, :2],
            round(float(places[0, 2]), 3),
            0.0,
            lambda base: self._arm(base, name).drop(self.carry, places),
            DROP_TILTS,
        )
        report.stands.append(stand.pose)
        yield from self._drive(stand.way, True)
        arm = self._arm(self._now.base, name)
        yield from self._play(arm.drop(self._set, places), True)
        self._now = yield Command(suction=False)
        yield from self._wait(LET_GO_S)
        yield from self._play(arm.carry(self._set, self.carry, False), False)
        if not self._binned(name):
            at = self._now.pieces[name][:3, 3]
            raise _TryError(f"it was let go and lies at ({at[0]:.2f}, {at[1]:.2f}), not in the bin")

    def _recovered(self) -> Work:
        """After a try that failed: suction off, the arm as it goes about."""
        self._now = yield Command(suction=False)
        yield from self._hold()
        yield from self._play(self._arm(self._now.base, "").carry(self._set, self.carry, False), False)

    def _stand(
        self,
        targets: FloatArray,
        height_m: float,
        lift_m: float,
        plan: Callable[[Pose2], object],
        tilts: Optional[Tuple[float, ...]] = None,
    ) -> Stand[object]:
        space = self._space()
        reach = reach_map(height_m, lift_m) if tilts is None else reach_map(height_m, lift_m, tilts)
        ways = space.ways_from(self._now.base)
        stand = choose_stand(ways, targets, reach, plan, lambda poses: np.asarray(space.gaps(poses) >= STAND_MARGIN_M))
        self._tell(
            f"stand ({stand.pose.x:.2f}, {stand.pose.y:.2f}), {np.degrees(stand.pose.yaw_rad):.0f} deg, "
            f"{len(stand.way)} corners"
        )
        return stand

    def _drive(self, way: Sequence[Pose2], holding: bool) -> Work:
        follower = Follower(way)
        while not follower.done(self._now.time_s):
            self._now = yield Command(follower.step(self._now.base, self._now.time_s))
            if holding and not self._now.grasping:
                self._now = yield Command()
                raise _TryError("the piece was lost on the way")
            if follower.reason:
                self._now = yield Command()
                raise _TryError(follower.reason)
        yield from self._wait(SETTLE_S)

    def _play(self, motions: Sequence[Trajectory], holding: bool) -> Work:
        for motion in motions:
            self._now = yield Command(motion=motion)
            self._set = motion.at(motion.duration_s)
            ended = self._now.time_s + motion.duration_s
            while self._now.time_s < ended:
                self._now = yield Command()
                if holding and not self._now.grasping:
                    yield from self._hold()
                    raise _TryError("the piece was lost while the arm moved")
        yield from self._wait(SETTLE_S)

    def _hold(self) -> Work:
        """Stay where the arm is now."""
        self._set = self._now.joints
        self._now = yield Command(motion=quintic(self._set, self._set, arm_limits()))
        yield from self._wait(SETTLE_S)

    def _wait(self, seconds: float) -> Work:
        ended = self._now.time_s + seconds
        while self._now.time_s < ended:
            self._now = yield Command()

    def _drop_places(self) -> FloatArray:
        """Points (n, 3) of the cup over the bin, world; the next piece's first."""
        rim = self._scene.bin.size[2]
        cleared = sum(report.cleared for report in self.pieces.values())
        aside = np.roll(DROP_ASIDE_M, -cleared)
        up = rim + OVER_RIM_M + LOAD_M[2] + 0.015
        return transform_points(self._scene.bin.pose, [(0.02, y, up) for y in aside])

    def _binned(self, name: str) -> bool:
        inside = np.linalg.inv(self._scene.bin.pose) @ self._now.pieces[name][:, 3]
        half = 0.5 * np.array(self._scene.bin.size[:2])
        return bool(np.all(np.abs(inside[:2]) < half) and inside[2] < self._scene.bin.size[2])

    def _lying(self) -> List[Tuple[str, Solid]]:
        """Pieces on the floor as boxes, world: not what is in the bin and not what hangs on the cup."""
        found = []
        for name, pose in self._now.pieces.items():
            if pose[2, 3] < PIECE_M[2] and not self._binned(name):
                found.append((name, Solid(Shape.BOX, PIECE_M, pose)))
        return found

    def _space(self) -> FloorSpace:
        box = self._scene.bin
        things = [Standing("bin", box.place, (0.5 * box.size[0], 0.5 * box.size[1]), box.size[2])]
        things += [standing(name, solid) for name, solid in [*self._scene.obstacles, *self._lying()]]
        return FloorSpace(HALF_M, things, self._under_arm_m)

    def _arm(self, base: Pose2, target: str) -> ArmWork:
        """The arm's planner with the base at a pose; the piece that is worked on is nothing to keep away from."""
        others = [(name, solid) for name, solid in self._lying() if name != target]
        return ArmWork(base, [*self._scene.boxes(), *others], self._seed)

    def _distance(self, name: str) -> float:
        at = self._now.pieces[name]
        return self._now.base.distance(Pose2(float(at[0, 3]), float(at[1, 3])))

    def _tell(self, text: str) -> None:
        self._say(f"{self._now.time_s:6.1f} s  {text}")


def weight_fault(name: str, mass_kg: float) -> str:
    """Why a piece is too heavy; empty when it is not."""
    weight_n = GRAVITY_MPS2 * mass_kg
    if weight_n > HOLDING_N:
        return f"{name} weighs {mass_kg:.2f} kg, {weight_n:.1f} N: the cup holds {HOLDING_N:g} N"
    if mass_kg > PAYLOAD_KG:
        return f"{name} weighs {mass_kg:.2f} kg: the arm carries {PAYLOAD_KG:g} kg"
    return ""

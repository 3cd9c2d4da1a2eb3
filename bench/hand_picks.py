#!/usr/bin/env python3
"""Single picks by the ankurbot's hand in full physics: how often debris is taken, held, carried off and never harmed.

    python3 bench/hand_picks.py [--picks 500] [--placed 100]

Each pick draws a place on the part or the table and the piece's yaw. Either the base stands somewhere within 7 cm of
where it should, brings the tip over the piece as it was seen and picks, up to three tries, each seen and aligned anew
(yarm.control's own base controller and hand work): seen within 5 mm (rows ``aligned``), or as far off as perception saw
one of a hundred pieces (rows ``seen``; the medians of ``bench/data/pieces.csv``, along and across the piece, drawn anew
for each try). Or the base was put there with an error of the tip of up to 0.01 or 0.03 m, and has one try without
looking. At the end the robot backs off for 1.6 s and
stops. A row a pick goes to ``bench/data/hand_picks.csv``; a run that was stopped goes on where it was.
"""

from __future__ import annotations

import argparse
import math
from functools import lru_cache
from pathlib import Path
from typing import Callable, Dict, List, Tuple

import numpy as np
from pieces import MEDIAN
from planning_table import Row, Table, read_rows

from yarm.control.actions import MobileAction
from yarm.control.base.controller import BaseController, BaseGoal, Outcome
from yarm.control.base.params import BaseParams
from yarm.control.hand import HandCommand, HandParams, HandReading, HandWork
from yarm.experiments.statistics import wilson_interval
from yarm.geometry import FloatArray, Pose2
from yarm.sim.engine.world import TICK_S, SimWorld
from yarm.sim.robots.ankurbot import Ankurbot
from yarm.sim.robots.hand import SuctionHand
from yarm.sim.scenes.scene import scene_from
from yarm.sim.scenes.specs import ThingSpec

ROWS = Path(__file__).resolve().parent / "data" / "hand_picks.csv"
VALUES = ("on_part", "x", "y", "off_m", "tries", "taken", "held", "force_n", "touched", "reason")
PIECES = ROWS.with_name("pieces.csv")
ALIGNED, SEEN = "aligned", "seen"
SEEDS = {ALIGNED: 1000, SEEN: 2000}
PLACED_M = (0.01, 0.03)
"""Greatest errors of a tip whose base was put there."""
BEGINS_WITHIN_M, BEGINS_WITHIN_RAD = 0.07, math.radians(10.0)
"""A base that aligns itself begins so far off."""
SEEN_WITHIN_M = 0.005
"""Greatest error of a piece's middle as it is seen."""
TRIES = 3
PIECE, ROBOT = "debris_1", "ankurbot_1"
PIECE_M = 0.04
PART_TOP_M, TABLE_TOP_M = 0.73, 0.70
REACH_M = 1.30
DOWN_LIMIT_TICKS = 120
DRIVE_LIMIT_MPS = 5.0
ALIGN_LIMIT_S, SETTLE_S = 30.0, 0.5
AWAY_MPS, AWAY_S = 0.5, 1.6


def main() -> int:
    """Add the missing rows and print the shares."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--picks", type=int, default=500, help="with a base that aligns itself, of each kind")
    options.add_argument("--placed", type=int, default=100, help="with a base that was put there, for each error")
    chosen = options.parse_args()
    table = Table(ROWS, ("error_m", "pick"), VALUES)
    for error, count in (
        (ALIGNED, chosen.picks),
        (SEEN, chosen.picks),
        *((f"{error_m:g}", chosen.placed) for error_m in PLACED_M),
    ):
        for number in range(count):
            table.add({"error_m": error, "pick": number}, lambda e=error, n=number: Pick(e, n).played())
    rows = read_rows(ROWS)
    for error in sorted({row["error_m"] for row in rows}):
        tell(error, [row for row in rows if row["error_m"] == error])
    return 0


def tell(error: str, rows: List[Row]) -> None:
    """Print the shares of the picks of one kind."""
    print(f"{len(rows)} picks, tip {error if error in SEEDS else f'within {error} m'}")
    for name, count in (
        ("taken at the first try", sum(row["taken"] == "True" and row["tries"] == "1" for row in rows)),
        (f"taken within {TRIES} tries", sum(row["taken"] == "True" for row in rows)),
        ("carried off", sum(row["held"] == "True" for row in rows)),
    ):
        low, high = wilson_interval(count, len(rows))
        share = f"{100.0 * count / len(rows):.1f} %"
        print(f"{name}: {count} of {len(rows)} = {share} (95 % interval {100 * low:.1f} to {100 * high:.1f})")
    forces = [float(row["force_n"]) for row in rows]
    print(f"force on the cup, N: {' / '.join(f'{v:.1f}' for v in np.percentile(forces, (50, 99, 100)))} (p50/p99/max)")
    print(f"touches that nobody may: {sum(int(row['touched']) for row in rows)}")


class Pick:
    """One pick, drawn from its number alone."""

    def __init__(self, error: str, number: int) -> None:
        """Draw it.

        Args:
            error: ``ALIGNED``, ``SEEN``, or the greatest error of the tip, metres.
            number: of the pick.
        """
        self._rng = np.random.default_rng((number, SEEDS[error] if error in SEEDS else round(1000 * float(error))))
        self._aligns = error in SEEDS
        self._errors = seen_errors() if error == SEEN else None
        self._on_part = bool(self._rng.integers(2))
        low, high = ((-0.42, -0.27), (-0.08, 0.27)) if self._on_part else ((0.045, -0.5), (0.35, 0.5))
        self._x, self._y = self._rng.uniform(low, high).tolist()
        heading = math.pi + (self._rng.uniform(-1.0, 1.0) * BEGINS_WITHIN_RAD if self._aligns else 0.0)
        off = self._disc(BEGINS_WITHIN_M if self._aligns else float(error))
        tip = np.array((self._x, self._y)) + off
        body = tip - REACH_M * np.array((math.cos(heading), math.sin(heading)))
        robot = {"name": ROBOT, "type": "ankurbot", "x": float(body[0]), "y": float(body[1])}
        robot["heading_deg"] = math.degrees(heading)
        self._scene = scene_from({"name": "pick", "fixtures": ["table"], "robots": [robot]}, "pick")
        self._yaw = float(self._rng.uniform(-math.pi, math.pi))
        self._most_n = 0.0

    def played(self) -> Dict[str, object]:
        """Play it; the row's values."""
        top = PART_TOP_M if self._on_part else TABLE_TOP_M
        with SimWorld(self._scene, hands=True) as world:
            world.spawn(ThingSpec(PIECE, "Debris", self._x, self._y, top + 0.5 * PIECE_M + 0.003, self._yaw))
            world.run(SETTLE_S)
            world.contacts.take()
            robot = world.robots[ROBOT]
            assert robot.hand is not None
            piece = world.bodies[PIECE].uids[0]
            tries, reason, off = self._tried(world, robot, robot.hand)
            taken = robot.hand.held_uid == piece
            robot.hand.lift_to(0.0)
            for caster in ("fl", "fr", "rl", "rr"):
                robot.steer(caster, 0.0)
            world.run(1.5)
            robot.drive(-AWAY_MPS, 0.0, DRIVE_LIMIT_MPS)
            world.run(AWAY_S)
            robot.drive(0.0, 0.0, DRIVE_LIMIT_MPS)
            world.run(SETTLE_S)
            return {
                "on_part": self._on_part,
                "x": round(self._x, 4),
                "y": round(self._y, 4),
                "off_m": round(off, 5),
                "tries": tries,
                "taken": taken,
                "held": robot.hand.held_uid == piece,
                "force_n": round(self._most_n, 2),
                "touched": len(world.failures()),
                "reason": reason,
            }

    def _tried(self, world: SimWorld, robot: Ankurbot, hand: SuctionHand) -> Tuple[int, str, float]:
        """Tries it took, why the last one failed, and how far the tip was off the piece's middle then."""
        if not self._aligns:
            off = _off(world)
            self._lowered(world, hand)
            return 1, "" if hand.grasping else "not taken", off
        number, reason, off = 0, "not tried", math.inf
        while reason and number < TRIES:
            number += 1
            reason = self._aligned(world, robot)
            off = _off(world)
            reason = reason or self._worked(world, hand)
        return number, reason, off

    def _aligned(self, world: SimWorld, robot: Ankurbot) -> str:
        """Bring the tip over the piece as it is seen; why it is not there."""
        seen = _middle(world) + self._seen_off(world)
        heading = _tip(world).yaw_rad
        goal = BaseGoal(Pose2(*seen.tolist(), heading), tolerance_m=HandParams().hand_tolerance_m)
        return driven(world, robot, goal, self._tick)

    def _seen_off(self, world: SimWorld) -> FloatArray:
        """How far (2,) beside its middle the piece is seen, metres in the world."""
        if self._errors is None:
            return self._disc(SEEN_WITHIN_M)
        along, across = self._errors[self._rng.integers(len(self._errors))]
        axes: FloatArray = world.transforms()[PIECE][:2, :2]
        return axes @ np.array((along, across))

    def _worked(self, world: SimWorld, hand: SuctionHand) -> str:
        """Pick as the controls server does; why it failed."""
        return worked(world, hand, MobileAction.PICK, self._tick)

    def _lowered(self, world: SimWorld, hand: SuctionHand) -> None:
        """Lower the hand until it has something or the way ends."""
        hand.on()
        hand.lift_to(hand.stroke_m)
        for _ in range(DOWN_LIMIT_TICKS):
            self._tick(world)
            if hand.grasping:
                break

    def _tick(self, world: SimWorld) -> None:
        world.run(TICK_S)
        hand = world.robots[ROBOT].hand
        assert hand is not None
        self._most_n = max([self._most_n, *hand.press_n().values()])

    def _disc(self, radius_m: float) -> FloatArray:
        """A random point (2,) of a disc, uniform over its area."""
        angle, away = self._rng.uniform(-math.pi, math.pi), radius_m * math.sqrt(self._rng.uniform())
        return np.array((away * math.cos(angle), away * math.sin(angle)))


@lru_cache(maxsize=1)
def seen_errors() -> FloatArray:
    """Errors (n, 2) of pieces' middles as perception saw them, metres along and across the piece."""
    rows = [row for row in read_rows(PIECES) if row["of"] == MEDIAN]
    return np.array([(float(row["along_m"]), float(row["across_m"])) for row in rows])


def driven(world: SimWorld, robot: Ankurbot, goal: BaseGoal, tick: Callable[[SimWorld], None]) -> str:
    """Drive as the controls server does, ``tick`` by ``tick``; why it failed."""
    controller = BaseController(BaseParams())
    controller.start(goal)
    ended = world.time_s + ALIGN_LIMIT_S
    while world.time_s < ended:
        angles = [reading.angle for reading in robot.caster_readings()]
        command = controller.step(_tip(world), angles, world.time_s)
        for caster, angle in zip(("fl", "fr", "rl", "rr"), command.casters or ()):
            robot.steer(caster, angle)
        robot.drive(command.drive_mps, command.yaw_rate_radps, DRIVE_LIMIT_MPS)
        if command.outcome is not Outcome.ACTIVE:
            return "" if command.outcome is Outcome.SUCCEEDED else command.reason
        tick(world)
    return f"not aligned within {ALIGN_LIMIT_S:g} s"


def worked(world: SimWorld, hand: SuctionHand, action: MobileAction, tick: Callable[[SimWorld], None]) -> str:
    """Pick or drop as the controls server does, ``tick`` by ``tick``; why it failed."""
    work = HandWork(HandParams())
    command = work.start(action, _reading(hand), world.time_s)
    while command.outcome is Outcome.ACTIVE:
        _send(hand, command)
        tick(world)
        command = work.step(_reading(hand), world.time_s)
    _send(hand, command)
    return "" if command.outcome is Outcome.SUCCEEDED else command.reason


def _tip(world: SimWorld) -> Pose2:
    at = world.transforms()[f"{ROBOT}/ee"]
    return Pose2(float(at[0, 3]), float(at[1, 3]), math.atan2(at[1, 0], at[0, 0]))


def _middle(world: SimWorld) -> FloatArray:
    """Middle (2,) of the piece, world."""
    return np.array(world.transforms()[PIECE][:2, 3])


def _off(world: SimWorld) -> float:
    tip = _tip(world)
    return float(np.linalg.norm(_middle(world) - (tip.x, tip.y)))


def _reading(hand: SuctionHand) -> HandReading:
    return HandReading(hand.lift_m, hand.lift_speed_mps, hand.grasping)


def _send(hand: SuctionHand, command: HandCommand) -> None:
    if command.suction is not None:
        if command.suction:
            hand.on()
        else:
            hand.off()
    if command.lift_m is not None:
        hand.lift_to(command.lift_m)


if __name__ == "__main__":
    raise SystemExit(main())

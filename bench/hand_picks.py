#!/usr/bin/env python3
"""Single picks by the ankurbot's hand in full physics: how often debris is taken, held, carried off and never harmed.

    python3 bench/hand_picks.py [--picks 500] [--errors 0.01 0.03]

Each pick draws a place on the part or the table, the piece's yaw, and an error of the tip of up to so many metres
(docs/control.md: a base alone stops within 0.03). The hand comes down, takes, draws up; the robot backs off for 1.6 s
and stops. Counted are pieces taken at the first try, pieces still held at the end, and the greatest force on the cup;
a row a pick goes to ``bench/data/hand_picks.csv``.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict, dataclass
from typing import Dict, List, Sequence

import numpy as np
import raw_rows

from yarm.experiments.statistics import wilson_interval
from yarm.sim.engine.world import TICK_S, SimWorld
from yarm.sim.robots.hand import SuctionHand
from yarm.sim.scenes.scene import scene_from
from yarm.sim.scenes.specs import ThingSpec

PIECE_M = 0.04
PART_TOP_M, TABLE_TOP_M = 0.73, 0.70
REACH_M = 1.30
DOWN_LIMIT_TICKS = 120


@dataclass(frozen=True)
class Pick:
    """What came of one pick.

    Attributes:
        on_part: drawn on the part, else on the table.
        x, y: centre of the piece, metres, world frame.
        off_m: error of the tip that was drawn, metres.
        taken: held when the hand came to its lowest.
        held: still held at the end.
        force_n: greatest force on the cup, N.
        touched: touches that nobody may.
    """

    on_part: bool
    x: float
    y: float
    off_m: float
    taken: bool
    held: bool
    force_n: float
    touched: int


def main() -> int:
    """Run the picks and print the shares."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--picks", type=int, default=500)
    options.add_argument("--errors", type=float, nargs="+", default=[0.01, 0.03], help="greatest errors of the tip, m")
    options.add_argument("--seed", type=int, default=1)
    chosen = options.parse_args()
    rows: List[Dict[str, object]] = []
    for error_m in chosen.errors:
        rng = np.random.default_rng(chosen.seed)
        picks = [picked(rng, error_m) for _ in range(chosen.picks)]
        rows += [{"error_m": error_m, "pick": number, **asdict(pick)} for number, pick in enumerate(picks)]
        tell(error_m, picks)
    raw_rows.save(raw_rows.DATA / "hand_picks.csv", rows)
    return 0


def tell(error_m: float, picks: Sequence[Pick]) -> None:
    """Print the shares of the picks with one greatest error."""
    n = len(picks)
    print(f"errors of the tip up to {error_m:g} m")
    for name, count in (
        ("taken at the first try", sum(p.taken for p in picks)),
        ("carried off", sum(p.held for p in picks)),
    ):
        low, high = wilson_interval(count, n)
        print(f"{name}: {count} of {n} = {100.0 * count / n:.1f} % (95 % interval {100 * low:.1f} to {100 * high:.1f})")
    print(f"greatest force on a cup: {max(p.force_n for p in picks):.1f} N")
    print(f"touches that nobody may: {sum(p.touched for p in picks)}")


def picked(rng: np.random.Generator, error_m: float) -> Pick:
    """One pick, drawn and played."""
    on_part = bool(rng.integers(2))
    x, y = rng.uniform((-0.42, -0.27), (-0.08, 0.27)) if on_part else rng.uniform((0.0, -0.5), (0.35, 0.5))
    angle, off = rng.uniform(-math.pi, math.pi), error_m * math.sqrt(rng.uniform())
    tip = x + off * math.cos(angle), y + off * math.sin(angle)
    robot = {"name": "ankurbot_1", "type": "ankurbot", "x": tip[0] + REACH_M, "y": tip[1], "heading_deg": 180.0}
    scene = scene_from({"name": "pick", "fixtures": ["table"], "robots": [robot]}, "pick")
    top = PART_TOP_M if on_part else TABLE_TOP_M
    with SimWorld(scene, hands=True) as world:
        yaw = float(rng.uniform(-math.pi, math.pi))
        world.spawn(ThingSpec("debris_1", "Debris", float(x), float(y), top + 0.5 * PIECE_M + 0.003, yaw))
        world.run(0.5)
        world.contacts.take()
        hand = world.robots["ankurbot_1"].hand
        assert hand is not None
        force = lowered(world, hand)
        piece = world.bodies["debris_1"].uids[0]
        taken = hand.held_uid == piece
        hand.lift_to(0.0)
        world.run(1.5)
        world.robots["ankurbot_1"].drive(-0.5, 0.0, 5.0)
        world.run(1.6)
        world.robots["ankurbot_1"].drive(0.0, 0.0, 5.0)
        world.run(0.5)
        return Pick(
            on_part,
            round(float(x), 4),
            round(float(y), 4),
            round(float(off), 5),
            taken,
            hand.held_uid == piece,
            round(force, 2),
            len(world.failures()),
        )


def lowered(world: SimWorld, hand: SuctionHand) -> float:
    """Lower the hand until it has something or the way ends; the greatest force on the cup, N."""
    hand.on()
    hand.lift_to(hand.stroke_m)
    most = 0.0
    for _ in range(DOWN_LIMIT_TICKS):
        world.run(TICK_S)
        most = max([most, *hand.press_n().values()])
        if hand.grasping:
            break
    return most


if __name__ == "__main__":
    raise SystemExit(main())

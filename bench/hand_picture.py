#!/usr/bin/env python3
"""Draws how the ankurbot's hand takes a piece of debris to a bin, in full physics: docs/images/hand_sequence.png.

    source tools/env.sh && python3 bench/hand_picture.py docs/images/hand_sequence.png

Base controller and hand work are the controls server's; the base begins 5 cm off.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import List, Tuple

from hand_picks import PIECE, PIECE_M, REACH_M, ROBOT, SETTLE_S, TABLE_TOP_M, driven, worked
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from yarm.control.actions import MobileAction
from yarm.control.base.controller import BaseGoal
from yarm.control.hand import HandParams
from yarm.geometry import Pose2
from yarm.sim.engine.world import TICK_S, SimWorld
from yarm.sim.scenes.scene import scene_from
from yarm.sim.scenes.specs import ThingSpec
from yarm.sim.sensors.snapshot import draw

PLACE, BIN = (0.22, 0.05), (0.45, -1.05)
OFF_M = (0.03, 0.04)
EYES_M = {PLACE: (-0.6, -1.3, 1.5), BIN: (-0.5, -2.5, 1.5)}
AIMS_M = {PLACE: (0.45, 0.1, 0.75), BIN: (0.75, -0.95, 0.65)}
PIXELS = (640, 480)


class Sequence:
    """Pictures of a world, each with a title."""

    def __init__(self, world: SimWorld) -> None:
        """None yet."""
        self._world = world
        self.pictures: List[Tuple[str, object]] = []

    def take(self, title: str, at: Tuple[float, float]) -> None:
        """One picture more."""
        self.pictures.append((title, draw(self._world, *PIXELS, EYES_M[at], AIMS_M[at])))

    def while_down(self, title: str, at: Tuple[float, float], holds: bool) -> None:
        """A picture the first time the hand, far down, holds something or no longer does."""
        hand = self._world.robots[ROBOT].hand
        assert hand is not None
        if hand.grasping is holds and hand.lift_m > 0.1 and all(title not in shown for shown, _ in self.pictures):
            self.take(f"{title}, {hand.lift_m:.3f} m down", at)


def main() -> None:
    """Pick, carry, let go; six pictures on one sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    path = parser.parse_args().file
    x, y = PLACE[0] + OFF_M[0] + REACH_M, PLACE[1] + OFF_M[1]
    robot = {"name": ROBOT, "type": "ankurbot", "x": x, "y": y, "heading_deg": 180.0}
    bins = [{"name": "bin_1", "x": BIN[0], "y": BIN[1]}]
    scene = scene_from({"name": "sequence", "fixtures": ["table"], "robots": [robot], "bins": bins}, "sequence")
    with SimWorld(scene, hands=True) as world:
        world.spawn(ThingSpec(PIECE, "Debris", *PLACE, TABLE_TOP_M + 0.5 * PIECE_M + 0.003, 0.7))
        world.run(SETTLE_S)
        pictures = played(world)
    figure = Figure(figsize=(12.0, 6.6), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (title, picture) in zip(figure.subplots(2, 3).flat, pictures):
        axes.imshow(picture)
        axes.set_title(title, fontsize=10)
        axes.axis("off")
    figure.savefig(str(path), dpi=100)


def played(world: SimWorld) -> List[Tuple[str, object]]:
    """The work, and its pictures.

    Raises:
        RuntimeError: a step of it failed.
    """
    shown = Sequence(world)
    moving = world.robots[ROBOT]
    assert moving.hand is not None

    def over(place: Tuple[float, float]) -> BaseGoal:
        return BaseGoal(Pose2(*place, math.pi), tolerance_m=HandParams().hand_tolerance_m)

    def picking(_: SimWorld) -> None:
        world.run(TICK_S)
        shown.while_down("the cup holds it", PLACE, True)

    def dropping(_: SimWorld) -> None:
        world.run(TICK_S)
        shown.while_down("let go", BIN, False)

    def tick(_: SimWorld) -> None:
        world.run(TICK_S)

    shown.take(f"the tip is {100.0 * math.hypot(*OFF_M):.0f} cm beside the piece", PLACE)
    reasons = [driven(world, moving, over(PLACE), tick)]
    shown.take("the base has aligned within 1 cm", PLACE)
    reasons.append(worked(world, moving.hand, MobileAction.PICK, picking))
    reasons.append(driven(world, moving, over(BIN), tick))
    shown.take("drawn up and carried over the bin", BIN)
    reasons.append(worked(world, moving.hand, MobileAction.DROP, dropping))
    world.run(SETTLE_S)
    found = world.bin_of(PIECE)
    shown.take(f"at rest in {found}, the hand empty", BIN)
    if any(reasons) or not found:
        raise RuntimeError(f"the piece is in {found or 'no bin'}: {'; '.join(filter(None, reasons))}")
    return shown.pictures


if __name__ == "__main__":
    main()

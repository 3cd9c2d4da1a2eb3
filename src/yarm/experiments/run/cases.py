"""The experiments that ship: which scene, how long, and what must come out beyond "everybody arrived"."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Dict, FrozenSet, Mapping

from yarm.commander.params import Removal
from yarm.geometry import STRAY
from yarm.geometry.kinds import GOAL_KINDS
from yarm.sim.scenes.scene import Scene


@dataclass(frozen=True)
class Case:
    """One experiment.

    Attributes:
        name: its name, also the scene's (``scenes/<name>.yaml``).
        title: what happens, in one line.
        limit_s: simulated seconds the mission may take.
        min_pauses: the manipulator must have paused at least this often.
        min_replans: a path must have changed under way at least this often.
        everybody: every robot must have reached something.
        refusals: a goal given up with a reason is no fault.
        may_fail: nor is a mission that ends failed because of such a goal.
        holds: no hand may lose a piece that it carries.
        with_bin: the same case with a bin, which is run in its place unless reached debris is to be deleted.
    """

    name: str
    title: str
    limit_s: float = 180.0
    min_pauses: int = 0
    min_replans: int = 0
    everybody: bool = False
    refusals: bool = False
    may_fail: bool = False
    holds: bool = False
    with_bin: str = ""

    def for_layout(self, own: bool, removal: Removal, sands_elsewhere: bool = False) -> Case:
        """What is demanded of a layout, the scene file's own or one that a seed draws.

        Where debris is carried to a bin, one robot may well bring all of it in a layout that nobody chose, and no path
        needs to change: then only the goals and the pauses count. A manipulator that sands elsewhere need not pause.
        """
        case = dataclasses.replace(self, min_pauses=0) if sands_elsewhere else self
        return case if own or removal is not Removal.BIN else dataclasses.replace(case, min_replans=0, everybody=False)


CASES: Mapping[str, Case] = {
    case.name: case
    for case in (
        Case("1m1ma", "one robot, one debris on the part, the HC10 sanding", 180.0, min_pauses=1, with_bin="1m1ma_bin"),
        Case(
            "2m1ma",
            "two robots, two debris that slip, the HC10 sanding",
            300.0,
            min_replans=1,
            everybody=True,
            with_bin="2m1ma_bin",
        ),
        Case(
            "1m1ma_bin",
            "one robot with a hand carries one debris to a bin, the HC10 sanding",
            240.0,
            min_pauses=1,
            holds=True,
        ),
        Case(
            "2m1ma_bin",
            "two robots with hands carry two debris that slip to a bin, the HC10 sanding",
            360.0,
            min_replans=1,
            everybody=True,
            holds=True,
        ),
        Case(
            "3m6_bin",
            "three robots with hands carry six debris to two bins, the HC10 tucked away",
            480.0,
            everybody=True,
            holds=True,
        ),
        Case("2m2ma", "two robots, two HC10s sanding at stations of their own", 300.0, min_pauses=2),
        Case("3m", "three robots cross, the HC10 tucked away", 240.0),
        Case("single", "one robot past the table, no HC10", 120.0),
        Case("1m1ma_target", "one robot to a target past the sanding HC10", 240.0),
        Case("soak", "missions repeated with debris at random", refusals=True),
    )
}

CELL_PREFIX = "random_"
"""Names of random cells, and the folders of their results, begin with it."""
CELL_LIMIT_S = 600.0
"""Simulated seconds for 8 debris and the 120 s until a mission gives up what nobody can reach, more than once."""


def case_of(name: str) -> Case:
    """The case of that name; a random cell's; for a scene that is nobody's case, one without extra demands."""
    if name.startswith(CELL_PREFIX):
        return Case(name, "a random cell", CELL_LIMIT_S, refusals=True, may_fail=True)
    return CASES.get(name, Case(name, f"scene {name}"))


def expected_goals(scene: Scene) -> FrozenSet[str]:
    """Names of all debris and targets of a scene, of those too that an event brings; unregistered ones as seen."""
    goals = [thing for thing in scene.all_things if thing.kind in GOAL_KINDS]
    named = {thing.name for thing in goals if thing.registered}
    return frozenset(named | {f"{STRAY}{number + 1}" for number in range(len(goals) - len(named))})


def layout_of(scene: Scene) -> Mapping[str, Mapping[str, float]]:
    """Where everything of a scene begins, or falls, by name, and how far each event pushes: metres, degrees."""
    spawned = [event.spawn for event in scene.events if event.spawn is not None]
    layout: Dict[str, Mapping[str, float]] = {
        robot.name: {"x": robot.x, "y": robot.y, "heading_deg": math.degrees(robot.heading_rad)}
        for robot in scene.robots
    }
    for thing in (*scene.things, *spawned):
        layout[thing.name] = {"x": thing.x, "y": thing.y, "z": thing.z, "yaw_deg": math.degrees(thing.yaw_rad)}
    pushes = {event.name: {"dx": event.dx_m, "dy": event.dy_m} for event in scene.events if event.push}
    return {**layout, **pushes}

"""The cell at one moment, as it is forked: plain data, from a scene, a moment of a recorded run, or the live cell."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Dict, List, Mapping, Tuple

import yaml

from yarm.experiments.run.cases import layout_of
from yarm.geometry import Pose2
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.robots.ankurbot import ARM_REACH_M
from yarm.sim.scenes.scene import Scene, SceneError, load_scene

MOST_ROBOTS = 4
TUCKED = "tucked"
"""Kind of an arm that stays folded; of one at work it is empty."""
CORNERS_M = tuple(Pose2(x, y, yaw) for x, yaw in ((0.6, math.pi), (-0.6, 0.0)) for y in (1.9, -1.9))
"""End effectors of robots that are added, metres, world, where nobody is near."""
APART_M = 1.0
"""An added robot's end effector is so far from any other's, metres."""


class WhatIfError(ValueError):
    """A question that cannot be asked; the message says what is wrong and what is allowed."""


class NoCellError(RuntimeError):
    """There is no live cell; the message says what was waited for."""


Settings = Tuple[Tuple[str, str], ...]
"""Names and values, as texts."""
COUNTED = ("planner", "particles", "turns_deg", "execution", "removal", "check_steps", "hidden", "sand_elsewhere")
"""Parameters of a Commander that its forks take over; the last two count in physics only."""


@dataclass(frozen=True)
class Placed:
    """Something at a place: name, what it is, x, y, z, metres, and heading, rad, world.

    ``size`` is a box's, metres, or the joints of an arm that stays folded, rad.
    """

    name: str
    kind: str
    x: float
    y: float
    z: float = 0.0
    yaw_rad: float = 0.0
    size: Tuple[float, ...] = ()


@dataclass(frozen=True)
class Cell:
    """A cell as it is forked.

    Attributes:
        source: what it is, for people.
        robots: end effectors of the mobile robots; kind is empty.
        arms: stations of the manipulators.
        fixtures: tables, stands and bins, by type.
        goals: debris and targets.
        obstacles: boxes, z in their middle.
        share: of the raster that is done, 0 to 1; negative: drawn anew in each run.
        scene: a scene whose layout each run draws anew; empty: only starts and debris are moved a little.
        settings: of its Commander, where they are not the usual ones.
    """

    source: str
    robots: Tuple[Placed, ...]
    arms: Tuple[Placed, ...] = ()
    fixtures: Tuple[Placed, ...] = ()
    goals: Tuple[Placed, ...] = ()
    obstacles: Tuple[Placed, ...] = ()
    share: float = -1.0
    scene: str = ""
    settings: Settings = ()

    @property
    def bins(self) -> Tuple[Placed, ...]:
        """The bins among the fixtures."""
        return tuple(fixture for fixture in self.fixtures if fixture.kind == "bin")

    def with_robots(self, count: int) -> Cell:
        """The cell with so many robots: its first ones, or more where there is room.

        Raises:
            WhatIfError: there is no room, or the number is out of range.
        """
        if not 1 <= count <= MOST_ROBOTS:
            raise WhatIfError(f"robots = {count}: must be within 1 to {MOST_ROBOTS}")
        robots = list(self.robots[:count])
        for corner in CORNERS_M:
            free = all(math.hypot(corner.x - r.x, corner.y - r.y) > APART_M for r in robots)
            if len(robots) < count and free:
                name = next(f"ankurbot_{n}" for n in range(1, 10) if f"ankurbot_{n}" not in {r.name for r in robots})
                robots.append(Placed(name, "", corner.x, corner.y, 0.0, corner.yaw_rad))
        if len(robots) < count:
            raise WhatIfError(f"robots = {count}: {self.source} has room for {len(robots)} where they would be added")
        return replace(self, robots=tuple(robots))


def cell_of(scene: Scene, source: str, drawn_from: str = "", in_physics: bool = False) -> Cell:
    """A scene as it is laid out; what its events bring is there from the beginning.

    Raises:
        WhatIfError: it has what the kinematic world does not know.
    """
    things = scene.all_things
    modelled = [thing.name for thing in things if thing.model and thing.kind == ObjectKind.OBSTACLE]
    if modelled and not in_physics:
        raise WhatIfError(f"{source}: {', '.join(modelled)}: the kinematic world knows boxes only; ask with --physics")
    robots = []
    for robot in scene.robots:
        tip = Pose2(robot.x, robot.y, robot.heading_rad).compose(Pose2(ARM_REACH_M, 0.0))
        robots.append(Placed(robot.name, "", tip.x, tip.y, 0.0, tip.yaw_rad))
    placed = [Placed(t.name, t.kind, t.x, t.y, t.z, t.yaw_rad, tuple(t.size)) for t in things]
    return Cell(
        source,
        tuple(robots),
        tuple(
            Placed(
                arm.name,
                TUCKED if arm.tucked else "",
                arm.station.x,
                arm.station.y,
                0.0,
                arm.station.yaw_rad,
                tuple(arm.station.folded) if arm.tucked else (),
            )
            for arm in scene.arms
        ),
        tuple(Placed(f.name, f.type, f.station.x, f.station.y, 0.0, f.station.yaw_rad) for f in scene.placed_fixtures),
        tuple(thing for thing in placed if thing.kind in GOAL_KINDS),
        tuple(thing for thing in placed if thing.kind == ObjectKind.OBSTACLE),
        scene=drawn_from,
    )


def cell_of_case(case: str, seed: int = -1, in_physics: bool = False) -> Cell:
    """A shipped scene, or a file, as a seed lays it out; one that can be is laid out anew in each run.

    Raises:
        WhatIfError: there is none, or it leaves no room.
    """
    try:
        scene = load_scene(case, seed)
    except SceneError as error:
        raise WhatIfError(str(error)) from error
    return cell_of(scene, f"scene {scene.name}", case if in_physics or scene.vary is not None else "", in_physics)


def cell_of_run(folder: Path, at_s: float) -> Cell:
    """A moment of a recorded run, s since its mission began: robots where they were, and what was not removed yet.

    Raises:
        WhatIfError: there is no such run, or it was over then.
    """
    try:
        summary: Mapping[str, Any] = yaml.safe_load((folder / "summary.yaml").read_text())
        arguments = yaml.safe_load((folder / "arguments.yaml").read_text())["arguments"]
        with (folder / "path.csv").open(newline="") as stream:
            path = list(csv.DictReader(stream))
        words: Dict[str, str] = dict(word.split(":=", 1) for word in arguments)
        scene = load_scene(words["case"], int(words["seed"]) if words.get("vary", "true") == "true" else -1)
    except (OSError, KeyError, TypeError, ValueError, SceneError) as error:
        raise WhatIfError(f"{folder}: no results of a mission that can be forked: {error}") from error
    if not 0.0 <= at_s <= float(summary["sim_s"]):
        raise WhatIfError(f"--at {at_s:g}: {folder} has a mission of {summary['sim_s']:.1f} s, from 0 on")
    cell = cell_of(scene, f"{folder} at {at_s:g} s")
    robots = [_robot_at(robot, path, at_s) for robot in cell.robots]
    places, gone = layout_of(scene), {n for n, g in summary["goals"].items() if _gone(g, at_s)}
    left = [goal for goal in cell.goals if goal.name not in gone]
    goals = tuple(replace(goal, x=places[goal.name]["x"], y=places[goal.name]["y"]) for goal in left)
    settings = tuple((name, words[name]) for name in COUNTED if name in words)
    return replace(cell, robots=tuple(robots), goals=goals, share=_share(folder, at_s), settings=settings)


def _gone(goal: Mapping[str, Any], at_s: float) -> bool:
    """Whether a goal of a summary was reached by then."""
    return goal["declared_s"] is not None and float(goal["declared_s"]) <= at_s


def _robot_at(robot: Placed, path: List[Dict[str, str]], at_s: float) -> Placed:
    rows = [row for row in path if row["robot"] == robot.name and float(row["time_s"]) <= at_s]
    if not rows:
        return robot
    return replace(robot, x=float(rows[-1]["x_m"]), y=float(rows[-1]["y_m"]), yaw_rad=float(rows[-1]["yaw_rad"]))


def _share(folder: Path, at_s: float) -> float:
    """Share of the part's squares that were sanded by then."""
    try:
        with (folder / "squares.csv").open(newline="") as stream:
            rows = list(csv.DictReader(stream))
    except OSError:
        return -1.0
    done = sum(float(row["sanded_s"]) <= at_s for row in rows)
    return min(0.99, done / len(rows)) if rows else -1.0

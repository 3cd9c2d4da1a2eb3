"""A random cell (``yarm.sim.scenes.random_cell``) as a kinematic mission, and what is wrong with how it went."""

from __future__ import annotations

import enum
from typing import Dict, List, Mapping, Optional, Set, Tuple

import numpy as np

from python.commander.fake_cell import SPEC, FakeArm, FakeCell
from yarm.commander.params import CommanderParams
from yarm.experiments.cells.outcome import CellResult, CellSpec
from yarm.experiments.run.cases import CELL_PREFIX
from yarm.geometry import IntArray, Pose2
from yarm.geometry.kinds import ObjectKind
from yarm.robots.ankurbot import ARM_REACH_M
from yarm.sim.checks.cell_check import unreachable_goals
from yarm.sim.checks.reachability import solid_points
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.events import Event, Script, Situation
from yarm.sim.scenes.random_cell import FALL_S, PERSON, random_cell
from yarm.sim.scenes.scene import Scene
from yarm.sim.scenes.specs import ThingSpec

LIMIT_S, GIVE_UP_S = 600.0, 20.0
"""Simulated time that a mission may take, and that it goes on with nothing left but what nobody can reach, s."""
ENOUGH_S = FALL_S + 1.0
"""Until then everything that an event brings is there, s of a mission."""
ARM = "hc10_barc"
GONE_S = 3.0
"""How long a controls server stays away, s."""


class Fault(enum.Enum):
    """Who is gone in the midst of a mission, as soon as a robot is on its way after each of so many seconds."""

    COMMANDER = "the Commander dies, and the next one takes up its memory"
    CONTROLS = "the controls server dies and comes back without memory"


STRUCK_S: Tuple[float, ...] = (1.0, 8.0, 15.0)
"""Seconds of the mission after which a fault happens."""


class RandomMission:
    """Runs one cell: its fleet, goals, obstacles and events; the person and the cameras are for physics.

    The manipulator stays as it is at the start; folded or not, its body is in the way.
    """

    def __init__(self, scene: Scene, fault: Optional[Fault] = None) -> None:
        """Everything where the scene begins, and calibrated."""
        self.struck: List[Tuple[float, Tuple[str, ...]]] = []
        self._came: Set[str] = set()
        self._fault, self._due, self._gone = fault, list(STRUCK_S), {}
        robots = {}
        for robot in scene.robots:
            tip = Pose2(robot.x, robot.y, robot.heading_rad).compose(Pose2(ARM_REACH_M, 0.0))
            robots[robot.name] = (tip.x, tip.y, robot.heading_rad)
        self.scene = scene
        self.cell = FakeCell(CommanderParams(give_up_s=GIVE_UP_S), **robots)
        standing = cells_of_bodies(scene)
        if not scene.arms[0].tucked:
            self.cell.arms[ARM] = FakeArm(body=standing.pop(ARM))
        unknown = {thing.name for thing in scene.things if not thing.registered}
        self.cell.statics = {f"unknown_{name}" if name in unknown else name: c for name, c in standing.items()}
        for thing in scene.things:
            self._add(thing)
        self._script = Script(tuple(event for event in scene.events if not event.camera and not _walks(event)))
        self.cell.calibrate()

    def run(self) -> CellResult:
        """Until the Commander has nothing left to do; what became of the cell."""
        cell, goals = self.cell, self._goals()
        assert cell.request(jump_state=5).success
        self._due = [cell.now + after_s for after_s in STRUCK_S]
        end_s, enough_s = cell.now + LIMIT_S, cell.now + ENOUGH_S
        while cell.now < end_s:
            self._happen()
            self._strike()
            cell.tick()
            if not cell.idle():
                continue
            if cell.now > enough_s and (cell.status.outcome == "failed" or not goals & self._there()):
                break
            cell.request(current_state=True)
        return self._result(goals)

    def _result(self, goals: Set[str]) -> CellResult:
        unreachable = unreachable_goals(self.scene)
        left = goals & self._there()
        reached = sorted((goals & self._came) - left)
        return CellResult(
            CellSpec(self.scene.name[len(CELL_PREFIX) :], self.scene.seed),
            tuple(self._faults(goals, unreachable)),
            tuple(reached),
            tuple(sorted(left & set(unreachable))),
            (),
            tuple(name for name in reached if name in unreachable),
            len(self.scene.robots),
            self.cell.now,
        )

    def _faults(self, goals: Set[str], unreachable: Mapping[str, str]) -> List[str]:
        cell = self.cell
        given_up = {t.goal: t.reason for t in cell.status.tasks if t.status == "unreachable"}
        faults = [f"{name} never came" for name in sorted(goals - self._came)]
        for name in sorted(goals & self._there()):
            if name not in unreachable:
                faults.append(f"{name} was not reached: {given_up.get(name) or cell.status}")
            elif not given_up.get(name):
                faults.append(f"{name} was neither reached nor refused with a reason: {cell.status}")
        if cell.status.busy:
            faults.append(f"not over after {LIMIT_S:g} s: {cell.status}")
        return faults + [f"{a} touched {b} at {at_s:.2f} s" for at_s, a, b in cell.touches[:3]]

    def _strike(self) -> None:
        """The fault, when it is due and somebody is on its way; whoever is back by now is found."""
        cell = self.cell
        for name in [name for name, until_s in self._gone.items() if cell.now >= until_s]:
            del self._gone[name]
            cell.find(name)
        under_way = tuple(name for name, r in cell.robots.items() if r.goal is not None and r.goal.target is not None)
        if self._fault is None or not self._due or cell.now < self._due[0] or not under_way or self._gone:
            return
        self._due.pop(0)
        self.struck.append((cell.now, under_way))
        if self._fault is Fault.COMMANDER:
            cell.start_commander_again(taken_up=True)
            return
        for name in cell.robots:  # one server is that of all of them
            self._gone[name] = cell.now + GONE_S
            cell.lose(name)

    def _goals(self) -> Set[str]:
        spawned = [event.spawn for event in self.scene.events if event.spawn is not None]
        return {t.name for t in (*self.scene.things, *spawned) if t.kind in (ObjectKind.DEBRIS, ObjectKind.TARGET)}

    def _there(self) -> Set[str]:
        return {*self.cell.debris, *self.cell.targets}

    def _add(self, thing: ThingSpec) -> None:
        self._came.add(thing.name)
        if thing.kind == ObjectKind.TARGET:
            self.cell.targets[thing.name] = (thing.x, thing.y)
        elif thing.kind == ObjectKind.DEBRIS:
            self.cell.debris[thing.name], self.cell.heights[thing.name] = (thing.x, thing.y), thing.z

    def _happen(self) -> None:
        cell = self.cell
        at: Dict[str, Tuple[float, float]] = {**cell.debris, **cell.targets}
        at.update({name: (robot.x, robot.y) for name, robot in cell.robots.items()})
        for event in self._script.fired(Situation(cell.now, cell.status.state.name, positions=at)):
            if event.spawn is not None:
                self._add(event.spawn)
            elif event.push in cell.debris:
                x, y = cell.debris[event.push]
                cell.debris[event.push] = (x + event.dx_m, y + event.dy_m)


def _walks(event: Event) -> bool:
    return PERSON in (event.move, event.delete) or (event.spawn is not None and event.spawn.name == PERSON)


def cells_of_bodies(scene: Scene) -> Dict[str, IntArray]:
    """Cells (n, 3) of the grid in which fixtures, obstacles and the manipulator are as a scene begins, by name.

    After one tick, as ``cell_check`` looks at them: the manipulator gives way a little under its weight.
    """
    with SimWorld(scene) as world:
        world.tick()
        poses = world.transforms()
        return {
            name: np.unique(
                SPEC.cells_inside(solid_points((s, poses[s.frame] @ s.T_frame_solid) for s in body.solids)), axis=0
            )
            for name, body in world.bodies.items()
            if body.kind in (ObjectKind.OBSTACLE, ObjectKind.MANIPULATOR)
        }


def run_cell(spec: CellSpec) -> CellResult:
    """The mission in a random cell."""
    return RandomMission(random_cell(spec.kind, spec.seed)).run()

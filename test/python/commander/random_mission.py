"""A random cell (``yarm.sim.scenes.random_cell``) as a kinematic mission, and what is wrong with how it went."""

from __future__ import annotations

import math
from typing import Dict, List, Tuple

import numpy as np

from python.commander.fake_cell import SPEC, FakeArm, FakeCell
from yarm.commander.params import CommanderParams
from yarm.geometry import IntArray, Pose2
from yarm.geometry.kinds import ObjectKind
from yarm.robots.ankurbot import ARM_REACH_M
from yarm.sim.checks.cell_check import unreachable_goals
from yarm.sim.scenes.events import Event, Script, Situation
from yarm.sim.scenes.random_cell import FALL_S, PERSON, random_cell
from yarm.sim.scenes.scene import Scene
from yarm.sim.scenes.specs import ThingSpec

LIMIT_S, GIVE_UP_S = 600.0, 20.0
"""Simulated time that a mission may take, and that it goes on with nothing left but what nobody can reach, s."""
ENOUGH_S = FALL_S + 1.0
"""Until then everything that an event brings is there, s of a mission."""
ARM = "hc10_barc"


class RandomMission:
    """Runs one cell: its fleet, goals, obstacles and events; the person and the cameras are for physics."""

    def __init__(self, scene: Scene) -> None:
        """Everything where the scene begins, and calibrated."""
        robots = {}
        for robot in scene.robots:
            tip = Pose2(robot.x, robot.y, robot.heading_rad).compose(Pose2(ARM_REACH_M, 0.0))
            robots[robot.name] = (tip.x, tip.y, robot.heading_rad)
        self.scene = scene
        self.cell = FakeCell(CommanderParams(give_up_s=GIVE_UP_S), **robots)
        self.cell.arms[ARM] = FakeArm()
        for thing in scene.things:
            self._add(thing)
        self._script = Script(tuple(event for event in scene.events if not event.camera and not _walks(event)))
        self.cell.calibrate()

    def run(self) -> List[str]:
        """Until the Commander has nothing left to do; what is wrong, one sentence each."""
        cell, goals = self.cell, self._goals()
        assert cell.request(jump_state=5).success
        end_s, enough_s = cell.now + LIMIT_S, cell.now + ENOUGH_S
        while cell.now < end_s:
            self._happen()
            cell.tick()
            if not cell.idle():
                continue
            if cell.now > enough_s and (cell.status.outcome == "failed" or not goals & self._there()):
                break
            cell.request(current_state=True)
        return self._faults(goals)

    def _faults(self, goals: set) -> List[str]:
        cell, unreachable = self.cell, unreachable_goals(self.scene)
        given_up = {t.goal: t.reason for t in cell.status.tasks if t.status == "unreachable"}
        faults = []
        for name in sorted(goals & self._there()):
            if name not in unreachable:
                faults.append(f"{name} was not reached: {given_up.get(name) or cell.status}")
            elif not given_up.get(name):
                faults.append(f"{name} was neither reached nor refused with a reason: {cell.status}")
        if cell.status.busy:
            faults.append(f"not over after {LIMIT_S:g} s: {cell.status}")
        return faults + [f"{a} touched {b} at {at_s:.2f} s" for at_s, a, b in cell.touches[:3]]

    def _goals(self) -> set:
        spawned = [event.spawn for event in self.scene.events if event.spawn is not None]
        return {t.name for t in (*self.scene.things, *spawned) if t.kind in (ObjectKind.DEBRIS, ObjectKind.TARGET)}

    def _there(self) -> set:
        return {*self.cell.debris, *self.cell.targets}

    def _add(self, thing: ThingSpec) -> None:
        if thing.kind == ObjectKind.TARGET:
            self.cell.targets[thing.name] = (thing.x, thing.y)
        elif thing.kind == ObjectKind.DEBRIS:
            self.cell.debris[thing.name], self.cell.heights[thing.name] = (thing.x, thing.y), thing.z
        else:
            self.cell.obstacles[thing.name if thing.registered else f"unknown_{thing.name}"] = box_cells(thing)

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


def box_cells(box: ThingSpec) -> IntArray:
    """Cells (n, 3) of the grid in which a box is."""
    axes = [np.linspace(-0.5 * size, 0.5 * size, max(2, math.ceil(size / 0.03) + 1)) for size in box.size]
    local = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    c, s = math.cos(box.yaw_rad), math.sin(box.yaw_rad)
    x, y = c * local[:, 0] - s * local[:, 1], s * local[:, 0] + c * local[:, 1]
    return SPEC.cells_inside(np.column_stack([x + box.x, y + box.y, local[:, 2] + box.z]))


def faults_of(kind: str, seed: int) -> List[str]:
    """What is wrong with the mission in a random cell."""
    return RandomMission(random_cell(kind, seed)).run()

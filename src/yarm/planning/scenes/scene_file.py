"""Planning scenes as YAML (scenes/planning/*.yaml): read with every fault named at once, and written.

grid: {shape: [50, 50, 20], min: [-2.5, -2.5, 0.01], max: [2.5, 2.5, 1.3]}
boxes: [[x0, x1, y0, y1, z0, z1], ...]          # occupied cells, ends exclusive
robots:
  - {name: ankurbot_1, cell: [38, 25], yaw_deg: 180, shape: ankurbot}
  - {name: cart, cell: [5, 5], cells: [[0, 0, 0], [-1, 0, 0]]}   # relative to the end effector, as it stands
goals:
  - {cell: [24, 28], kind: Debris, robot: ankurbot_1}            # optional: robot, name, yaw_deg

The limits below are there so that no file, right or wrong, costs more than a few seconds and 200 MB to read.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
import yaml

from yarm.geometry import GridError, GridSpec, IntArray
from yarm.geometry.grid import MAX_COLUMN_CELLS
from yarm.planning.model.types import Goal, GoalKind
from yarm.planning.scenes.scene import Box, PlanScene, SceneRobot, Stand
from yarm.yaml_fields import Faults, Fields, SceneError, load_yaml

KINDS = (GoalKind.DEBRIS.value, GoalKind.TARGET.value)
SHAPES = ("ankurbot",)
MOST_COLUMNS = 1000
"""Columns along x or y."""
MOST_CELLS = 1_000_000
"""Cells of the grid."""
CELL_SIZE_M = (0.02, 10.0)
"""Least and greatest size of a cell, metres."""
FAR_M = 1000.0
"""The grid lies within this far of the origin along each axis, metres."""
MOST_BOXES = 1000
MOST_BOX_CELLS = 2_000_000
"""Cells of all boxes together."""
MOST_ROBOTS = 50
MOST_ROBOT_CELLS = 10_000
MOST_GOALS = 200

__all__ = ["SceneError", "dump_scene", "load_scene", "parse_scene"]


def load_scene(path: Path) -> PlanScene:
    """Read a planning scene.

    Raises:
        SceneError: not readable, not YAML, or anything in it wrong; every fault is listed.
    """
    return parse_scene(load_yaml(Path(path)), str(path))


def parse_scene(content: object, where: str = "scene") -> PlanScene:
    """A planning scene from plain values; ``where`` is named in messages.

    Raises:
        SceneError: anything wrong; every fault is listed.
    """
    faults = Faults(where)
    top = Fields(content, "", faults)
    spec = _grid(top.section("grid"))
    boxes = _boxes(top, spec)
    robots = _robots(top, spec)
    goals, assignments = _goals(top, spec, [name for name, _ in robots])
    top.finish()
    faults.raise_if_any()
    assert spec is not None
    return PlanScene(
        spec, tuple(boxes), tuple(r for _, r in robots if r is not None), goals, assignments, Path(where).stem
    )


def dump_scene(scene: PlanScene) -> str:
    """YAML text that ``load_scene`` reads back as the same scene."""
    owners = {goal: robot for robot, goal in scene.assignments.items()}
    spec = scene.spec
    lines = [
        f"grid: {_flow({'shape': list(spec.shape), 'min': list(spec.lower), 'max': list(spec.upper)})}",
        f"boxes: {_flow([[int(v) for v in box] for box in scene.boxes])}",
        "robots:",
    ]
    for robot in scene.robots:
        entry: Dict[str, Any] = {"name": robot.name, "cell": [int(v) for v in robot.start.column]}
        entry["yaw_deg"] = round(math.degrees(robot.start.yaw_rad), 9)
        entry.update({"shape": "ankurbot"} if robot.cells is None else {"cells": robot.cells.tolist()})
        lines.append(f"  - {_flow(entry)}")
    lines.append("goals:" if scene.goals else "goals: []")
    for goal in scene.goals.values():
        entry = {"name": goal.name, "cell": [int(v) for v in goal.column], "kind": str(goal.kind)}
        if goal.yaw_rad is not None:
            entry["yaw_deg"] = round(math.degrees(goal.yaw_rad), 9)
        if goal.name in owners:
            entry["robot"] = owners[goal.name]
        lines.append(f"  - {_flow(entry)}")
    return "\n".join(lines) + "\n"


def _grid(fields: Fields) -> Optional[GridSpec]:
    shape = fields.wholes("shape", 3, 1, MOST_COLUMNS)
    lower = fields.numbers("min", 3, -FAR_M, FAR_M)
    upper = fields.numbers("max", 3, -FAR_M, FAR_M)
    complete = all(fields.has(name) for name in ("shape", "min", "max"))
    fields.finish()
    if shape is None or not complete:
        return None
    gx, gy, gz = shape
    if gz > MAX_COLUMN_CELLS:
        fields.faults.add(fields.path("shape"), shape, f"at most {MAX_COLUMN_CELLS} cells along z")
        return None
    if gx * gy * gz > MOST_CELLS:
        fields.faults.add(fields.path("shape"), shape, f"at most {MOST_CELLS} cells in all, not {gx * gy * gz}")
        return None
    least, most = CELL_SIZE_M
    sizes = [(high - low) / n for low, high, n in zip(lower, upper, shape)]
    if not all(least * (1.0 - 1e-9) <= size <= most for size in sizes):
        found = " x ".join(f"{size:.3g}" for size in sizes)
        fields.faults.add(fields.path("max"), upper, f"cells of {least:g} to {most:g} m on each side, not {found} m")
        return None
    return GridSpec((gx, gy, gz), (lower[0], lower[1], lower[2]), (upper[0], upper[1], upper[2]))


def _boxes(top: Fields, spec: Optional[GridSpec]) -> List[Box]:
    boxes: List[Box] = []
    cells = 0
    for key, (x0, x1, y0, y1, z0, z1) in top.rows("boxes", 6, 0, MOST_COLUMNS, MOST_BOXES):
        if spec is None:
            continue
        wrong = [
            f"0 <= {axis}0 < {axis}1 <= {n} (ends exclusive)"
            for axis, low, high, n in zip("xyz", (x0, y0, z0), (x1, y1, z1), spec.shape)
            if not low < high <= n
        ]
        if wrong:
            top.faults.add(key, [x0, x1, y0, y1, z0, z1], " and ".join(wrong))
            continue
        cells += (x1 - x0) * (y1 - y0) * (z1 - z0)
        boxes.append((x0, x1, y0, y1, z0, z1))
    if cells > MOST_BOX_CELLS:
        top.faults.add("boxes", f"{cells} cells in all boxes", f"at most {MOST_BOX_CELLS}")
    return boxes


def _robots(top: Fields, spec: Optional[GridSpec]) -> List[Tuple[str, Optional[SceneRobot]]]:
    """Name and robot of each entry, None for a robot that is wrong."""
    entries = top.entries("robots", MOST_ROBOTS)
    if not top.has("robots"):
        top.faults.add_missing("robots", "a list of at least one robot")
    elif top.raw["robots"] == []:
        top.faults.add("robots", [], "at least one robot")
    robots = [_robot(fields, spec) for fields in entries]
    names = [name for name, _ in robots if name]
    for name in sorted({name for name in names if names.count(name) > 1}):
        top.faults.add("robots", name, "a name that only one robot has")
    return robots


def _robot(fields: Fields, spec: Optional[GridSpec]) -> Tuple[str, Optional[SceneRobot]]:
    name = fields.text("name")
    column = _column(fields, spec)
    yaw = math.radians(fields.number("yaw_deg", -360.0, 360.0, "deg", 0.0))
    cells = None
    if fields.has("shape") == fields.has("cells"):
        if fields.raw:
            fields.faults.add(fields.key, fields.raw, "either shape: ankurbot or cells: [[dx, dy, z], ...]")
    elif fields.has("shape"):
        fields.text("shape", choices=SHAPES)
    else:
        cells = _mask_cells(fields, spec)
    fields.finish("shape", "cells")
    if column is None or spec is None or (cells is None and not fields.has("shape")):
        return name, None
    return name, _placed(SceneRobot(name, Stand(column, yaw), cells), fields, spec)


def _placed(robot: SceneRobot, fields: Fields, spec: GridSpec) -> Optional[SceneRobot]:
    """The robot, when the grid can hold it."""
    key = fields.path("shape" if robot.cells is None else "cells")
    try:
        extent = np.ptp(robot.mask(spec, robot.start.yaw_rad).cells, axis=0) + 1
    except GridError as error:
        fields.faults.add(key, robot.name, f"a robot that reaches into the grid: {error}")
        return None
    if np.any(extent > spec.shape):
        fields.faults.add(
            key,
            f"{' x '.join(map(str, extent))} cells",
            f"a robot no larger than the grid of {' x '.join(map(str, spec.shape))} cells",
        )
        return None
    return robot


def _mask_cells(fields: Fields, spec: Optional[GridSpec]) -> Optional[IntArray]:
    rows = [row for _, row in fields.rows("cells", 3, -MOST_COLUMNS, MOST_COLUMNS, MOST_ROBOT_CELLS)]
    given = fields.raw["cells"]
    if given == []:
        fields.faults.add(fields.path("cells"), given, "at least one cell")
    if not rows or spec is None or len(rows) != len(given):
        return None
    cells = np.unique(np.array(rows, dtype=np.int64), axis=0)
    if cells[:, 2].min() < 0 or cells[:, 2].max() >= spec.shape[2]:
        found = f"z {cells[:, 2].min()} to {cells[:, 2].max()}"
        fields.faults.add(fields.path("cells"), found, f"z within 0 to {spec.shape[2] - 1}")
        return None
    return cells


def _goals(top: Fields, spec: Optional[GridSpec], robots: Sequence[str]) -> Tuple[Dict[str, Goal], Dict[str, str]]:
    """Goals by name, and the goal of each robot that has a fixed one."""
    goals: Dict[str, Goal] = {}
    assignments: Dict[str, str] = {}
    for fields in top.entries("goals", MOST_GOALS):
        column = _column(fields, spec)
        kind = fields.text("kind", choices=KINDS) or KINDS[0]
        name = fields.text("name", fields.key)
        yaw = math.radians(fields.number("yaw_deg", -360.0, 360.0, "deg", 0.0)) if fields.has("yaw_deg") else None
        if name in goals:
            fields.faults.add(fields.path("name"), name, "a name that only one goal has")
        if fields.has("robot"):
            _assign(fields, name, robots, assignments)
        fields.finish("robot", "yaw_deg")
        goals[name] = Goal(name, GoalKind(kind), column or (0, 0), yaw_rad=yaw)
    return goals, assignments


def _assign(fields: Fields, goal: str, robots: Sequence[str], assignments: Dict[str, str]) -> None:
    robot = fields.text("robot", choices=[name for name in robots if name])
    if robot in assignments:
        fields.faults.add(fields.path("robot"), robot, f"a robot without another goal ({assignments[robot]})")
    elif robot:
        assignments[robot] = goal


def _column(fields: Fields, spec: Optional[GridSpec]) -> Optional[Tuple[int, int]]:
    cell = fields.wholes("cell", 2, 0, MOST_COLUMNS - 1)
    if cell is None or spec is None:
        return None
    gx, gy, _ = spec.shape
    if cell[0] >= gx or cell[1] >= gy:
        fields.faults.add(fields.path("cell"), cell, f"a cell within the grid, x 0 to {gx - 1}, y 0 to {gy - 1}")
        return None
    return cell[0], cell[1]


def _flow(value: Any) -> str:
    return str(yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10**6)).strip()

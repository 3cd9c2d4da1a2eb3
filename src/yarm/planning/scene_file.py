"""Planning scenes as YAML (scenes/planning/*.yaml): read with every fault named at once, and written.

grid: {shape: [50, 50, 20], min: [-2.5, -2.5, 0.01], max: [2.5, 2.5, 1.3]}
boxes: [[x0, x1, y0, y1, z0, z1], ...]          # occupied cells, ends exclusive
robots:
  - {name: ankurbot_1, cell: [38, 25], yaw_deg: 180, shape: ankurbot}
  - {name: cart, cell: [5, 5], cells: [[0, 0, 0], [-1, 0, 0]]}   # relative to the end effector, as it stands
goals:
  - {cell: [24, 28], kind: Debris, robot: ankurbot_1}            # optional: robot, name, yaw_deg
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import yaml

from yarm.geometry import GridError, GridSpec, IntArray
from yarm.planning.scene import Box, PlanScene, SceneRobot, Stand
from yarm.planning.types import Goal

KINDS = ("Debris", "Target")
MOST_CELLS = 20_000_000
"""Largest grid that is accepted, cells."""


class SceneError(ValueError):
    """A scene is wrong; the message lists every fault as file, key, value and what was expected."""


def load_scene(path: Path) -> PlanScene:
    """Read a planning scene.

    Raises:
        SceneError: not readable, not YAML, or anything in it wrong; every fault is listed.
    """
    try:
        content = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: cannot be read: {error}") from error
    except yaml.YAMLError as error:
        raise SceneError(f"{path}: is not YAML: {' '.join(str(error).split())}") from error
    return parse_scene(content, str(path))


def parse_scene(content: Any, where: str = "scene") -> PlanScene:
    """A planning scene from plain values; ``where`` is named in messages.

    Raises:
        SceneError: anything wrong; every fault is listed.
    """
    reader = _Reader(where)
    top = reader.mapping("", content, ("grid", "boxes", "robots", "goals"), ("grid", "robots"))
    spec = _read_grid(reader, top.get("grid"))
    boxes = [_read_box(reader, f"boxes[{i}]", box, spec) for i, box in reader.items("boxes", top.get("boxes", []))]
    robots = [_read_robot(reader, f"robots[{i}]", r, spec) for i, r in reader.items("robots", top.get("robots", []))]
    names = [robot.name for robot in robots if robot is not None]
    goals: Dict[str, Goal] = {}
    assignments: Dict[str, str] = {}
    for i, item in reader.items("goals", top.get("goals", [])):
        _read_goal(reader, f"goals[{i}]", item, spec, names, goals, assignments)
    for name in sorted({name for name in names if names.count(name) > 1}):
        reader.fault("robots", name, "a name that only one robot has")
    if "robots" in top and not top["robots"]:
        reader.fault("robots", top["robots"], "at least one robot")
    if reader.faults or spec is None:
        raise SceneError("\n".join(reader.faults))
    return PlanScene(
        spec, tuple(b for b in boxes if b), tuple(r for r in robots if r), goals, assignments, Path(where).stem
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
        entry = {"name": goal.name, "cell": [int(v) for v in goal.column], "kind": goal.kind}
        if goal.yaw_rad is not None:
            entry["yaw_deg"] = round(math.degrees(goal.yaw_rad), 9)
        if goal.name in owners:
            entry["robot"] = owners[goal.name]
        lines.append(f"  - {_flow(entry)}")
    return "\n".join(lines) + "\n"


class _Reader:
    """Checks values and collects every fault; a wrong value gives None, so that reading goes on."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.faults: List[str] = []

    def fault(self, key: str, value: Any, expected: str) -> None:
        shown = repr(value)
        shown = shown if len(shown) <= 80 else shown[:77] + "..."
        self.faults.append(f"{self.where}: {key or 'top level'} = {shown}: expected {expected}")

    def mapping(self, key: str, value: Any, known: Sequence[str], needed: Sequence[str]) -> Mapping[str, Any]:
        if not isinstance(value, dict):
            self.fault(key, value, f"a mapping with the keys {', '.join(known)}")
            return {}
        prefix = f"{key}." if key else ""
        for name in value:
            if name not in known:
                self.fault(f"{prefix}{name}", value[name], f"no such key; known: {', '.join(known)}")
        for name in needed:
            if name not in value:
                self.faults.append(f"{self.where}: {prefix}{name} is missing: expected it to be given")
        return {name: item for name, item in value.items() if name in known}

    def items(self, key: str, value: Any) -> List[Tuple[int, Any]]:
        if not isinstance(value, list):
            self.fault(key, value, "a list")
            return []
        return list(enumerate(value))

    def numbers(self, key: str, value: Any, count: int, whole: bool) -> Optional[Tuple[float, ...]]:
        kind = "whole numbers" if whole else "finite numbers"
        if not isinstance(value, list) or len(value) != count or not all(_is_number(v, whole) for v in value):
            self.fault(key, value, f"a list of {count} {kind}")
            return None
        return tuple(int(v) if whole else float(v) for v in value)

    def text(self, key: str, value: Any, check: Callable[[str], bool], expected: str) -> Optional[str]:
        if not isinstance(value, str) or not check(value):
            self.fault(key, value, expected)
            return None
        return value

    def column(self, key: str, value: Any, spec: Optional[GridSpec]) -> Optional[Tuple[int, int]]:
        cell = self.numbers(key, value, 2, whole=True)
        if cell is None or spec is None:
            return None
        if not (0 <= cell[0] < spec.shape[0] and 0 <= cell[1] < spec.shape[1]):
            self.fault(key, value, f"a cell within the grid, x 0 to {spec.shape[0] - 1}, y 0 to {spec.shape[1] - 1}")
            return None
        return int(cell[0]), int(cell[1])

    def yaw(self, key: str, value: Any) -> Optional[float]:
        if not _is_number(value, whole=False):
            self.fault(key, value, "a finite number of degrees")
            return None
        return math.radians(float(value))


def _is_number(value: Any, whole: bool) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return False
    return abs(value) < 1e9 and (not whole or float(value).is_integer())


def _read_grid(reader: _Reader, value: Any) -> Optional[GridSpec]:
    if value is None:
        return None
    keys = ("shape", "min", "max")
    grid = reader.mapping("grid", value, keys, keys)
    shape = reader.numbers("grid.shape", grid["shape"], 3, whole=True) if "shape" in grid else None
    lower = reader.numbers("grid.min", grid["min"], 3, whole=False) if "min" in grid else None
    upper = reader.numbers("grid.max", grid["max"], 3, whole=False) if "max" in grid else None
    if shape is None or lower is None or upper is None:
        return None
    if all(n > 0 for n in shape) and math.prod(shape) > MOST_CELLS:
        reader.fault("grid.shape", value["shape"], f"at most {MOST_CELLS} cells in all")
        return None
    try:
        return GridSpec((int(shape[0]), int(shape[1]), int(shape[2])), lower[:3], upper[:3])  # type: ignore[arg-type]
    except GridError as error:
        reader.fault("grid", value, f"a grid: {error}")
        return None


def _read_box(reader: _Reader, key: str, value: Any, spec: Optional[GridSpec]) -> Optional[Box]:
    ends = reader.numbers(key, value, 6, whole=True)
    if ends is None or spec is None:
        return None
    x0, x1, y0, y1, z0, z1 = (int(v) for v in ends)
    for low, high, cells, axis in (
        (x0, x1, spec.shape[0], "x"),
        (y0, y1, spec.shape[1], "y"),
        (z0, z1, spec.shape[2], "z"),
    ):
        if not 0 <= low < high <= cells:
            reader.fault(key, value, f"0 <= {axis}0 < {axis}1 <= {cells} (ends exclusive)")
            return None
    return x0, x1, y0, y1, z0, z1


def _read_robot(reader: _Reader, key: str, value: Any, spec: Optional[GridSpec]) -> Optional[SceneRobot]:
    entry = reader.mapping(key, value, ("name", "cell", "yaw_deg", "shape", "cells"), ("name", "cell"))
    name = reader.text(f"{key}.name", entry["name"], bool, "a name") if "name" in entry else None
    column = reader.column(f"{key}.cell", entry["cell"], spec) if "cell" in entry else None
    yaw = reader.yaw(f"{key}.yaw_deg", entry.get("yaw_deg", 0.0))
    if ("shape" in entry) == ("cells" in entry):
        reader.fault(key, value, "either shape: ankurbot or cells: [[dx, dy, z], ...]")
        return None
    cells = None
    if "shape" in entry:
        reader.text(f"{key}.shape", entry["shape"], lambda text: text == "ankurbot", "'ankurbot'")
    else:
        cells = _read_mask(reader, f"{key}.cells", entry["cells"], spec)
    if name is None or column is None or yaw is None or spec is None or ("cells" in entry and cells is None):
        return None
    robot = SceneRobot(name, Stand(column, yaw), cells)
    extent = np.ptp(robot.mask(spec, yaw).cells, axis=0) + 1
    if np.any(extent > spec.shape):
        reader.fault(
            f"{key}.{'shape' if cells is None else 'cells'}",
            f"{' x '.join(map(str, extent))} cells",
            f"a robot no larger than the grid of {' x '.join(map(str, spec.shape))} cells",
        )
    return robot


def _read_mask(reader: _Reader, key: str, value: Any, spec: Optional[GridSpec]) -> Optional[IntArray]:
    cells = [reader.numbers(f"{key}[{i}]", cell, 3, whole=True) for i, cell in reader.items(key, value)]
    if isinstance(value, list) and not value:
        reader.fault(key, value, "at least one cell")
    if not cells or any(cell is None for cell in cells) or spec is None:
        return None
    mask = np.unique(np.array(cells, dtype=np.int64), axis=0)
    if mask[:, 2].min() < 0 or mask[:, 2].max() >= spec.shape[2]:
        reader.fault(key, f"z {mask[:, 2].min()} to {mask[:, 2].max()}", f"z within 0 to {spec.shape[2] - 1}")
        return None
    return mask


def _read_goal(
    reader: _Reader,
    key: str,
    value: Any,
    spec: Optional[GridSpec],
    robots: Sequence[str],
    goals: Dict[str, Goal],
    assignments: Dict[str, str],
) -> None:
    entry = reader.mapping(key, value, ("cell", "kind", "robot", "name", "yaw_deg"), ("cell", "kind"))
    column = reader.column(f"{key}.cell", entry["cell"], spec) if "cell" in entry else None
    kind = reader.text(f"{key}.kind", entry.get("kind", KINDS[0]), KINDS.__contains__, " or ".join(KINDS))
    name = reader.text(f"{key}.name", entry.get("name", key), bool, "a name")
    yaw = reader.yaw(f"{key}.yaw_deg", entry["yaw_deg"]) if "yaw_deg" in entry else None
    if name in goals:
        reader.fault(f"{key}.name", name, "a name that only one goal has")
    if "robot" in entry:
        robot = reader.text(
            f"{key}.robot", entry["robot"], lambda text: text in robots, "the name of a robot of the scene"
        )
        if robot in assignments:
            reader.fault(f"{key}.robot", robot, f"a robot without another goal ({assignments[str(robot)]})")
        elif robot is not None and name is not None:
            assignments[robot] = name
    if column is not None and kind is not None and name is not None:
        goals[name] = Goal(name, kind, column, yaw_rad=yaw)


def _flow(value: Any) -> str:
    return str(yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10**6)).strip()

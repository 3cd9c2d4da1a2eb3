"""Goals of a scene without a robot are shared out: as many as can be, with the least travel."""

from __future__ import annotations

import yaml

from yarm.planning.model.params import PlannerParams
from yarm.planning.scenes.assignment import assign_goals
from yarm.planning.scenes.scene_file import parse_scene

SCENE = """
grid: {shape: [20, 12, 2], min: [0, 0, 0], max: [2.0, 1.2, 0.2]}
boxes: BOXES
robots:
  - {name: a, cell: [2, 2], cells: [[0, 0, 0]]}
  - {name: b, cell: [2, 8], cells: [[0, 0, 0]]}
goals: GOALS
"""


def shared(boxes: str, goals: str):
    scene = parse_scene(yaml.safe_load(SCENE.replace("BOXES", boxes).replace("GOALS", goals)))
    return assign_goals(scene, PlannerParams())


def goal(x: int, y: int, more: str = "") -> str:
    return f"{{cell: [{x}, {y}], kind: Target{more}}}"


def test_the_sum_of_ways_is_least() -> None:
    result = shared("[]", f"[{goal(15, 8)}, {goal(15, 2)}]")
    assert result.assignments == {"a": "goals[1]", "b": "goals[0]"} and result.unserved == {}


def test_what_the_scene_says_stays() -> None:
    result = shared("[]", f"[{goal(15, 8, ', robot: a')}, {goal(15, 2)}]")
    assert result.assignments == {"a": "goals[0]", "b": "goals[1]"}


def test_more_goals_than_robots_and_goals_behind_a_wall_are_named() -> None:
    more = shared("[]", f"[{goal(3, 2)}, {goal(3, 8)}, {goal(15, 8)}]")
    assert set(more.assignments.values()) == {"goals[0]", "goals[1]"}
    assert more.unserved == {"goals[2]": "goal goals[2] at (15, 8): every robot that could reach it has another goal"}
    walled = shared("[[10, 11, 0, 12, 0, 2]]", f"[{goal(15, 8)}]")
    assert walled.assignments == {}
    assert walled.unserved == {"goals[0]": "goal goals[0] at (15, 8): no robot without a goal can reach it"}

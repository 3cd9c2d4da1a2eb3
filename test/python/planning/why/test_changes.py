"""What the smallest change is, held against a complete search that shares no code with it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from python.planning.samples import SMALL, block, request, robot, walls
from yarm.geometry import GridSpec, Mask
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, GoalKind
from yarm.planning.scenes.infeasible import InfeasibleMaker, moved_boxes
from yarm.planning.scenes.oracle import Node, Shape, Space
from yarm.planning.scenes.scene import PlanScene, SceneRobot, Stand
from yarm.planning.why.causes import MOVE_LIMIT_CELLS, smallest_changes
from yarm.planning.why.changes import Change, ChangeKind, Crossing

SPEC = GridSpec((24, 24, 3), (0.0, 0.0, 0.0), (2.4, 2.4, 0.3))
CART = SceneRobot("cart_1", Stand((12, 12), 0.0), np.array([[0, 0, 0], [-1, 0, 0], [-2, 0, 0], [0, 0, 1]]))
KINDS = {ChangeKind.MOVE, ChangeKind.REMOVE, ChangeKind.MARGIN}


def crossing_of(scene):
    return Crossing(scene.request(), scene.robots[0].name, scene.goals["goal"], PlannerParams())


def feasible(scene, boxes, margin=True, turns_deg=PlannerParams.turns_deg):
    """Whether the scene's robot can come to its goal among other boxes, by the complete search."""
    mover = scene.robots[0]
    occupied = PlanScene(scene.spec, tuple(boxes), (), {}).occupied()
    space = Space(Shape(mover, scene.spec, turns_deg), occupied, margin)
    lengths = space.lengths(Node(space.shape.heading(mover.start.yaw_rad), *mover.start.column))
    return bool(np.isfinite(lengths[scene.goals["goal"].column]))


def with_changes(scene, changes):
    """Boxes and margin of a scene after some changes."""
    gone = {int(c.thing[6:-1]) for c in changes if c.kind is ChangeKind.REMOVE}
    boxes = list(scene.boxes)
    for change in changes:
        if change.kind is ChangeKind.MOVE:
            index = int(change.thing[6:-1])
            boxes[index] = moved_boxes(scene.boxes, index, *change.offset)[index]
    margin = all(change.kind is not ChangeKind.MARGIN for change in changes)
    return [box for i, box in enumerate(boxes) if i not in gone], margin


def single_changes(scene, crossing):
    """Every move and removal of every box, and the margin left out, the smallest first."""
    changes = [Change(ChangeKind.MARGIN)]
    for name in crossing.things:
        changes += [*crossing.moves(name, MOVE_LIMIT_CELLS), Change(ChangeKind.REMOVE, name)]
    return sorted(changes, key=lambda change: change.size)


@pytest.mark.parametrize("seed", range(6))
def test_the_smallest_change_makes_the_goal_reachable_and_no_smaller_one_does(seed):
    scene = InfeasibleMaker(SPEC, CART).make(seed)
    crossing = crossing_of(scene)
    found = smallest_changes(crossing)
    assert not feasible(scene, scene.boxes), f"seed {seed}"
    for changes in found:
        if {change.kind for change in changes} <= KINDS:
            boxes, margin = with_changes(scene, changes)
            assert feasible(scene, boxes, margin), f"seed {seed}: {[str(c) for c in changes]}"
    best = found[0] if found else ()
    for change in single_changes(scene, crossing):
        if len(best) == 1 and change.size >= best[0].size:
            break
        boxes, margin = with_changes(scene, [change])
        assert not feasible(scene, boxes, margin), f"seed {seed}: {change} is smaller than {[str(c) for c in best]}"


@pytest.mark.parametrize("seed", range(6))
def test_of_two_or_more_changes_none_can_be_left_out(seed):
    scene = InfeasibleMaker(SPEC, CART).make(seed)
    for changes in smallest_changes(crossing_of(scene)):
        for left_out in changes if {change.kind for change in changes} <= KINDS else ():
            boxes, margin = with_changes(scene, [change for change in changes if change != left_out])
            assert not feasible(scene, boxes, margin), f"seed {seed}: {left_out} need not be"


def ring(gap=()):
    """Full-height walls round the column (8, 6), one side of which may be left out."""
    sides = {"south": (5, 12, 3, 4), "north": (5, 12, 9, 10), "west": (5, 6, 3, 10), "east": (11, 12, 3, 10)}
    return {name: box for name, box in sides.items() if name not in gap}


def target(column=(8, 6), **fields):
    return Goal("goal", GoalKind.TARGET, column, **fields)


def cells_of(box):
    return np.argwhere(walls(SMALL, [box]))


def in_a_ring(mover, sides, **fields):
    objects = {name: cells_of(box) for name, box in sides.items()}
    return request(SMALL, walls(SMALL, sides.values()), [mover], [target()], objects=objects, **fields)


def changes_of(asked, params=None, bare=None, mover="r"):
    found = smallest_changes(Crossing(asked, mover, asked.goals["goal"], params or PlannerParams(), bare))
    return [tuple((change.kind, change.thing) for change in changes) for changes in found]


def test_what_nobody_named_is_told_by_its_place():
    sides = ring()
    objects = {name: cells_of(box) for name, box in sides.items() if name == "south"}
    asked = request(SMALL, walls(SMALL, sides.values()), [robot("r", (2, 6), block(1, 1))], [target()], objects=objects)
    things = Crossing(asked, "r", asked.goals["goal"], PlannerParams()).things
    assert list(things) == ["south", "something unknown at (0.85, 0.85) m"]


def test_what_two_things_share_stays_until_both_are_gone():
    sides = {**ring(("west",)), "west": (5, 6, 3, 10), "second west": (5, 6, 3, 10)}
    found = changes_of(in_a_ring(robot("r", (2, 6), block(1, 1)), sides))
    west = ((ChangeKind.REMOVE, "second west"), (ChangeKind.REMOVE, "west"))
    assert west not in [changes for changes in found if len(changes) == 1]
    crossing = Crossing(in_a_ring(robot("r", (2, 6), block(1, 1)), sides), "r", target(), PlannerParams())
    assert not crossing.reached([Change(ChangeKind.REMOVE, "west")])
    assert crossing.reached([Change(kind, thing) for kind, thing in west])


def test_a_robot_that_would_fit_without_its_load_is_told_to_lay_it_down():
    gap = {"low": (8, 9, 0, 4), "high": (8, 9, 8, 12)}
    carrying = robot("r", (3, 6), block(3, 5))
    objects = {name: cells_of(box) for name, box in gap.items()}
    mover = type(carrying)("r", carrying.column, 0.0, carrying.mask, carries="piece")
    asked = request(SMALL, walls(SMALL, gap.values()), [mover], [target((12, 6))], objects=objects)
    assert ((ChangeKind.LAY_DOWN, "piece"),) in changes_of(asked, bare=lambda yaw_rad: block(1, 1))
    assert all(kind is not ChangeKind.LAY_DOWN for changes in changes_of(asked) for kind, _ in changes)


def test_a_private_area_is_named_when_it_alone_keeps_a_robot_out():
    forbidden = np.zeros(SMALL.shape[:2], dtype=bool)
    forbidden[6:10] = True
    asked = request(SMALL, walls(SMALL, []), [robot("r", (2, 6), block(1, 1))], [target((12, 6))], forbidden=forbidden)
    assert changes_of(asked) == [((ChangeKind.ENTER, ""),)]


def test_turns_of_45_degrees_are_named_where_they_alone_would_do():
    body = [(x - 6, y, 0) for x in range(-2, 3) for y in range(-2, 3)]
    mover = robot("r", (10, 6), Mask(np.array(body + [(-k, 0, 2) for k in range(7)])))
    asked = request(SMALL, walls(SMALL, []), [mover], [target((1, 1))])
    assert changes_of(asked, PlannerParams(turns_deg=(0.0, 90.0, -90.0))) == [((ChangeKind.TURNS, ""),)]
    assert Crossing(asked, "r", target((1, 1)), PlannerParams(turns_deg=(0.0, 45.0, -45.0))).reached()


def test_a_thing_is_not_moved_into_another_nor_into_a_robot():
    sides = {"wall": (8, 9, 0, 12), "block": (12, 14, 5, 7)}
    crossing = Crossing(in_a_ring(robot("r", (3, 6), block(2, 2)), sides), "r", target((15, 11)), PlannerParams())
    offsets = {change.offset for change in crossing.moves("block", 8)}
    assert (-4, 0) not in offsets and (-3, 0) in offsets and (3, 0) not in offsets and (2, 0) in offsets
    assert {change.offset for change in crossing.moves("wall", 8)} == {(x, 0) for x in (-8, -7, -2, -1, 1, 2, 3, 6, 7)}


def test_an_unknown_robot_is_a_key_error():
    asked = request(SMALL, walls(SMALL, []), [robot("r", (2, 6), block(1, 1))], [target()])
    with pytest.raises(KeyError, match="there is no robot ghost"):
        Crossing(asked, "ghost", target(), PlannerParams())


def test_a_change_says_what_to_do():
    move = Change(ChangeKind.MOVE, "box", (1, -2), math.hypot(0.1, 0.2))
    assert str(move) == "move box by 0.22 m towards +x -y"
    assert str(Change(ChangeKind.REMOVE, "box")) == "remove box"

"""The safety monitor's geometry and its verdicts, without ROS."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from yarm.geometry import CarriedPiece, CellMap, GridSpec, MappedObject, Pose2, SeenPiece, transform_matrix
from yarm.geometry.solids import Shape, Solid, surface_points
from yarm.safety.clearance import (
    Body,
    Disc,
    Foresight,
    Motion,
    Passing,
    coasting,
    column_boxes,
    distance,
    placed,
    room_ahead,
    signed_distance,
    way_ahead,
)
from yarm.safety.loads import loads_of, with_loads
from yarm.safety.monitor import Monitor, Seen, bodies_for, own_goals
from yarm.safety.params import SafetyParams

EVERYWHERE = (np.full(3, -np.inf), np.full(3, np.inf))


def at(x=0.0, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = (x, y, z)
    return matrix


ROBOT = surface_points(
    [
        Solid(Shape.CYLINDER, (0.35, 0.45), at(-1.3, 0.0, -0.565)),
        Solid(Shape.BOX, (1.3, 0.08, 0.08), at(-0.65, 0.0, 0.0)),
    ],
    0.08,
)
WALL = Body("table", (Solid(Shape.BOX, (1.0, 4.0, 1.0), at(1.5, 0.0, 0.5)),))
HEIGHT = 0.89


@pytest.mark.parametrize(
    ("solid", "point", "expected"),
    [
        (Solid(Shape.BOX, (2.0, 2.0, 2.0), at()), (2.0, 0.0, 0.0), 1.0),
        (Solid(Shape.BOX, (2.0, 2.0, 2.0), at()), (0.0, 0.0, 0.75), -0.25),
        (Solid(Shape.SPHERE, (0.5,), at(1.0)), (1.0, 2.0, 0.0), 1.5),
        (Solid(Shape.CYLINDER, (0.5, 2.0), at()), (1.5, 0.0, 0.0), 1.0),
        (Solid(Shape.CYLINDER, (0.5, 2.0), at()), (0.0, 0.0, 1.25), 0.25),
        (Solid(Shape.CYLINDER, (0.5, 2.0), at()), (3.5, 0.0, 5.0), 5.0),
    ],
)
def test_signed_distances(solid, point, expected):
    assert signed_distance(np.array([point]), solid)[0] == pytest.approx(expected)


def test_boxes_of_the_map_count_as_bodies():
    body = Body("unknown_1", (), np.array([[1.0, -0.1, 0.8, 1.1, 0.1, 0.9]]))
    assert distance(np.array([[0.5, 0.0, 0.85]]), body, *EVERYWHERE) == pytest.approx(0.5)


def test_cells_above_each_other_are_one_box_and_no_cell_is_lost():
    spec = GridSpec()
    rng = np.random.default_rng(3)
    cells = np.unique(rng.integers((10, 10, 0), (14, 14, 20), size=(150, 3)), axis=0)
    boxes = column_boxes(spec, cells[rng.permutation(len(cells))])
    assert len(boxes) < len(cells)
    centres = spec.centres(cells)
    inside = np.all((centres[:, None] > boxes[:, :3]) & (centres[:, None] < boxes[:, 3:]), axis=2)
    assert np.all(inside.sum(axis=1) == 1)
    volume = np.prod(boxes[:, 3:] - boxes[:, :3], axis=1).sum()
    assert volume == pytest.approx(len(cells) * np.prod(spec.resolution))
    assert column_boxes(spec, np.zeros((0, 3), dtype=np.int64)).shape == (0, 6)


def test_a_person_is_as_near_by_its_boxes_as_by_its_cells():
    spec = GridSpec()
    cells = np.array([[x, y, z] for x in range(30, 34) for y in range(20, 24) for z in range(20)])
    half = spec.resolution / 2.0
    each = Body("person", (), np.hstack([spec.centres(cells) - half, spec.centres(cells) + half]))
    runs = Body("person", (), column_boxes(spec, cells))
    points = np.random.default_rng(4).uniform((-2.5, -2.5, 0.0), (2.5, 2.5, 1.3), size=(50, 3))
    for point in points:
        probe = point[None]
        assert distance(probe, runs, *EVERYWHERE) == pytest.approx(distance(probe, each, *EVERYWHERE))


def test_a_robot_is_placed_at_its_end_effector():
    points = placed(np.array([[-1.3, 0.0, -0.5]]), Pose2(1.0, 2.0, math.pi / 2), HEIGHT)
    assert points[0] == pytest.approx([1.0, 0.7, 0.39])


def test_coasting_ends_at_the_target():
    sight = Foresight()
    fast = Motion(vx=1.0)
    free = coasting(Pose2(0.0, 0.0), fast, None, sight)
    assert max(p.pose.x for p in free) == pytest.approx(sight.latency_s + 1.0 / (2 * sight.deceleration_mps2))
    bound = coasting(Pose2(0.0, 0.0), fast, Pose2(0.1, 0.0), sight)
    assert max(p.pose.x for p in bound) <= 0.11 + 1e-9
    assert coasting(Pose2(0.0, 0.0), Motion(), None, sight) == []


def test_a_robot_that_goes_by_a_pose_does_not_brake_there_and_first_goes_towards_it():
    sight = Foresight(latency_s=0.1, deceleration_mps2=1.5, reach_m=1.65)
    at, by, end = Pose2(0.0, 0.0), Pose2(0.1, 0.0), Pose2(1.0, 0.5)
    straight = coasting(at, Motion(1.0, 0.0, 0.0), by, sight)
    onward = coasting(at, Motion(1.0, 0.0, 0.0), end, sight, (by,))
    assert max(p.pose.x for p in straight) < 0.12
    assert max(p.pose.x for p in onward) > 0.4
    assert onward[-1].pose.y == 0.0, "the first stretch leads to where it goes by"
    back = coasting(at, Motion(1.0, 0.0, 0.0), Pose2(0.05, 0.0), sight, (Pose2(0.3, 0.0),))
    assert max(p.pose.x for p in back) > 0.25, "it may well drive past where it ends"


def test_poses_are_behind_once_a_robot_has_come_near_but_never_the_last():
    way = (Pose2(0.5, 0.0), Pose2(1.0, 0.0), Pose2(1.5, 0.0))
    assert way_ahead(way, Pose2(0.0, 0.0)) == way
    assert way_ahead(way, Pose2(0.45, 0.04)) == way[1:]
    assert way_ahead(way[1:], Pose2(0.0, 0.0)) == way[1:]
    assert way_ahead(way[2:], Pose2(1.5, 0.0)) == way[2:]
    assert way_ahead((), Pose2(0.0, 0.0)) == ()


def test_room_ahead_counts_the_motion_not_the_place():
    pose = Pose2(0.98, 0.0)
    limit = 0.03
    near = room_ahead(ROBOT, pose, HEIGHT, [Passing(Pose2(0.99, 0.0), 0.1)], [WALL], limit)
    assert near.closing and near.nearest == "table"
    away = room_ahead(ROBOT, pose, HEIGHT, [Passing(Pose2(0.9, 0.0), 0.1)], [WALL], limit)
    assert not away.closing
    along = room_ahead(ROBOT, Pose2(0.9, 0.0), HEIGHT, [Passing(Pose2(0.9, 0.3), 0.1)], [WALL], limit)
    assert not along.closing
    assert along.distance_m == pytest.approx(0.1, abs=0.01)


def anything(rng):
    """Something of turned solids and boxes, somewhere, that may move or be anybody's place."""
    solids = []
    for _ in range(rng.integers(0, 6)):
        turned = rng.normal(size=4)
        pose = transform_matrix(rng.uniform((-2.5, -2.5, 0.0), (2.5, 2.5, 1.2)), turned / np.linalg.norm(turned))
        solids.append(Solid(rng.choice(list(Shape)), tuple(rng.uniform(0.05, 0.4, 3)), pose))
    low = rng.uniform((-2.5, -2.5, 0.0), (2.5, 2.5, 1.2), (rng.integers(0, 20), 3))
    boxes = np.hstack([low, low + rng.uniform(0.05, 0.2, low.shape)]) if len(low) else None
    disc = Disc(*rng.uniform(-2.5, 2.5, 2), 0.3, 1.7, 1.0) if rng.random() < 0.2 else None
    walks = tuple(rng.normal(size=2)) if rng.random() < 0.3 else (0.0, 0.0)
    return Body("", tuple(solids), boxes, walks, 0.1, disc)


def rooms_point_by_point(pose, passed, body):
    """Least distance ahead and whether it closes in, of a robot whose points are all looked at everywhere."""
    now, ahead = placed(ROBOT, pose, HEIGHT), [placed(ROBOT, each.pose, HEIGHT) for each in passed]
    for walks in dict.fromkeys([(0.0, 0.0), body.velocity_mps]):
        ways = [np.array([*walks, 0.0]) * (body.age_s + after_s) for after_s in (0.0, *(p.after_s for p in passed))]
        then, on_way = now - ways[0], np.concatenate([points - way for points, way in zip(ahead, ways[1:])])
        box = on_way.min(axis=0) - 0.5, on_way.max(axis=0) + 0.5
        yield distance(on_way, body, *box), distance(then, body, *box)
    if body.disc is not None:
        discs = [body.disc.distance(points, body.age_s + each.after_s) for points, each in zip(ahead, passed)]
        yield min(discs), body.disc.distance(now, body.age_s)


def test_rooms_are_those_of_all_points():
    free = 0
    for seed in range(300):
        rng = np.random.default_rng(seed)
        pose, limit_m = Pose2(*rng.uniform(-2.0, 2.0, 2), rng.uniform(-3.0, 3.0)), rng.choice([0.03, 0.2])
        passed = coasting(pose, Motion(*rng.normal(0.0, 0.4, 3)), Pose2(*rng.uniform(-2.0, 2.0, 2)), Foresight())
        bodies = [replace(anything(rng), name=f"body_{i}") for i in range(3)]
        found = room_ahead(ROBOT, pose, HEIGHT, passed, bodies, limit_m)
        rooms = {body.name: list(rooms_point_by_point(pose, passed, body)) for body in bodies}
        least = {name: min(room for room, _ in own) for name, own in rooms.items()}
        if found.closing:
            assert least[found.nearest] == pytest.approx(found.distance_m, abs=1e-9), seed
            assert found.distance_m < limit_m, seed
        else:
            free += 1
            assert found.distance_m == pytest.approx(min(least.values()), abs=1e-9), seed
            assert found.nearest == min(least, key=least.get) or math.isinf(found.distance_m), seed
        closing = {name for name, own in rooms.items() if any(r < limit_m and r < was - 1e-3 for r, was in own)}
        assert found.closing or not closing, seed
    assert 50 < free < 250


def drive(monitor, poses, target, bodies, goal_id="g"):
    verdicts = []
    for i, x in enumerate(poses):
        seen = {"r": Seen(Pose2(x, 0.0), HEIGHT, ROBOT, target, goal_id)}
        verdicts.append(monitor.look(i / 30.0, seen, {"r": bodies})["r"])
    return verdicts


def test_a_robot_sent_at_the_table_is_stopped_before_it():
    monitor = Monitor(SafetyParams())
    poses = np.arange(0.0, 1.2, 1.0 / 30.0)
    verdicts = drive(monitor, poses, Pose2(1.5, 0.0), [WALL])
    first = next(i for i, v in enumerate(verdicts) if v.held)
    assert verdicts[first].stop_now
    assert 1.0 - poses[first] >= 1.0 / (2 * 1.5)
    assert "r on its step to (1.50, 0.00, 0 deg) would come within" in verdicts[first].reason
    assert "of table" in verdicts[first].reason


def test_a_good_step_beside_the_table_is_left_alone():
    monitor = Monitor(SafetyParams())
    poses = np.concatenate([np.arange(0.0, 0.94, 1.0 / 30.0), np.full(10, 0.94)])
    assert not any(v.held for v in drive(monitor, poses, Pose2(0.94, 0.0), [WALL]))


def test_a_step_that_begins_into_the_table_never_begins():
    verdicts = drive(Monitor(SafetyParams()), [0.97], Pose2(1.5, 0.0), [WALL])
    assert verdicts[0].stop_now


def test_a_held_robot_is_released_when_it_stands_and_may_leave():
    monitor = Monitor(SafetyParams(hold_s=0.2))
    assert drive(monitor, [0.97], Pose2(1.5, 0.0), [WALL])[0].held
    seen = {"r": Seen(Pose2(0.97, 0.0), HEIGHT, ROBOT, None, "")}
    assert monitor.look(0.1, seen, {"r": [WALL]})["r"].held
    assert not monitor.look(0.5, seen, {"r": [WALL]})["r"].held
    leaving = {"r": Seen(Pose2(0.96, 0.0), HEIGHT, ROBOT, Pose2(0.0, 0.0), "g2")}
    assert not monitor.look(0.6, leaving, {"r": [WALL]})["r"].held


def person_at(x, y, velocity_mps=(0.0, 0.0), age_s=0.0):
    """A person of 0.4 x 0.4 x 1.2 m as the grid has it: a box a column."""
    spec = GridSpec()
    cells = np.unique(spec.cells_inside(PERSON_POINTS + np.array([x, y, 0.0])), axis=0)
    return Body("unknown_1", (), column_boxes(spec, cells), velocity_mps, age_s)


PERSON_POINTS = np.array(
    [
        [x, y, z]
        for x in np.linspace(-0.2, 0.2, 9)
        for y in np.linspace(-0.2, 0.2, 9)
        for z in np.linspace(0.05, 1.2, 40)
    ]
)


def test_a_robot_that_presses_into_somebody_the_grid_knows_is_stopped():
    poses = [Pose2(0.02 + 0.01 * i, 0.0) for i in range(8)]
    monitor = Monitor(SafetyParams())
    person = person_at(0.25, 0.0)
    held = []
    for i, pose in enumerate(poses):
        seen = {"r": Seen(pose, HEIGHT, ROBOT, Pose2(1.5, 0.0), "g")}
        held.append(monitor.look(i / 30.0, seen, {"r": [person]})["r"].held)
    assert distance(placed(ROBOT, poses[-1], HEIGHT), person, *EVERYWHERE) == 0.0
    inside = Monitor(SafetyParams()).look(
        0.0, {"r": Seen(poses[-1], HEIGHT, ROBOT, Pose2(1.5, 0.0), "g")}, {"r": [person]}
    )
    assert inside["r"].stop_now
    away = Monitor(SafetyParams()).look(
        0.0, {"r": Seen(poses[-1], HEIGHT, ROBOT, Pose2(-1.5, 0.0), "g")}, {"r": [person]}
    )
    assert not away["r"].held


@pytest.mark.parametrize(
    ("velocity_mps", "age_s", "stops"), [((0.0, 0.0), 0.1, False), ((-1.0, 0.0), 0.1, True), ((1.0, 0.0), 0.1, False)]
)
def test_somebody_who_walks_towards_the_tip_stops_it_before_somebody_who_stands(velocity_mps, age_s, stops):
    person = person_at(1.2, 0.0, velocity_mps, age_s)
    assert any(v.held for v in drive(Monitor(SafetyParams()), [0.0, 1 / 30.0], Pose2(2.0, 0.0), [person])) is stops


def test_somebody_who_walks_into_the_arm_from_the_side_stops_it():
    for velocity_mps, stops in (((0.0, 0.0), False), ((0.0, 1.0), True), ((0.0, -1.0), False)):
        person = person_at(-0.2, -0.7, velocity_mps)
        verdicts = drive(Monitor(SafetyParams()), [0.0, 1 / 30.0], Pose2(2.0, 0.0), [person])
        assert any(v.held for v in verdicts) is stops, velocity_mps


def test_how_old_the_map_is_counts_as_way_of_whoever_walks():
    def held(age_s):
        person = person_at(1.8, 0.0, (-1.0, 0.0), age_s)
        return drive(Monitor(SafetyParams()), [0.0, 1 / 30.0], Pose2(2.0, 0.0), [person])[-1].held

    assert not held(0.0)
    assert held(0.4)


def test_own_goals_may_be_touched_others_not():
    debris = Body("debris_1", (Solid(Shape.BOX, (0.1, 0.1, 0.04), at()),))
    allowed = own_goals([("r", "debris_1"), ("s", "debris_2")])
    assert bodies_for("r", [debris, WALL], allowed["r"]) == [WALL]
    assert bodies_for("s", [debris, WALL], allowed["s"]) == [debris, WALL]


def test_a_robot_whose_pose_is_old_is_held_until_it_is_seen_again():
    monitor = Monitor(SafetyParams(stale_s=0.3))
    target = Pose2(1.0, 0.0)

    def look(now_s, age_s):
        seen = Seen(Pose2(0.0, 0.0), HEIGHT, ROBOT, target, "g", age_s)
        return monitor.look(now_s, {"r": seen}, {"r": []})["r"]

    assert not look(0.0, 0.3).held
    first, second = look(0.1, 0.4), look(0.2, 0.5)
    assert (first.held, first.stop_now, second.held, second.stop_now) == (True, True, True, False)
    assert first.reason == "r is not watched: its pose on /tf is 0.4 s old, allowed 0.3 s"
    assert not look(0.3, 0.0).held
    assert look(0.4, 0.4).stop_now


PIECE = [("debris_1", Solid(Shape.BOX, (0.15, 0.06, 0.04), at()))]


def map_with(carried, name="debris_1", piece=None):
    no_cells = np.zeros((0, 3), dtype=np.int64)
    found = MappedObject(name, "Debris", 1, (0.0, 0.0, 0.8), (0.0, 0.0, 0.0, 1.0), no_cells, piece, carried)
    return CellMap(0.0, GridSpec(), np.zeros(GridSpec().shape, dtype=np.int8), {name: found})


def test_what_hangs_on_a_hand_is_where_the_map_shows_it_on_the_hand():
    turned = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    (load,) = loads_of(map_with(CarriedPiece("r", (0.01, 0.0, -0.095), turned)), {"debris_1": PIECE}, 0.08)
    assert (load.piece, load.robot) == ("debris_1", "r")
    assert load.points.min(axis=0) == pytest.approx([-0.02, -0.075, -0.115])
    assert load.points.max(axis=0) == pytest.approx([0.04, 0.075, -0.075])
    assert len(with_loads("r", ROBOT, [load])) == len(ROBOT) + len(load.points)
    assert len(with_loads("other", ROBOT, [load])) == len(ROBOT)
    assert loads_of(map_with(None), {"debris_1": PIECE}, 0.08) == []


def test_what_nobody_registered_hangs_on_a_hand_as_the_box_that_is_seen():
    piece = SeenPiece(30, (0.0, 0.0, 0.82), 0.0, 0.15, 0.06)
    held = CarriedPiece("r", (0.0, 0.0, -0.095), (0.0, 0.0, 0.0, 1.0))
    (load,) = loads_of(map_with(held, "debris_auto_1", piece), {}, 0.08)
    assert load.points.min(axis=0) == pytest.approx([-0.075, -0.03, -0.115])
    assert load.points.max(axis=0) == pytest.approx([0.075, 0.03, -0.075])
    (other,) = loads_of(map_with(held, "debris_1", piece), {}, 0.08)
    assert len(other.points) == 0, "what is registered has the shape it is registered with"


def test_a_robot_is_stopped_by_what_its_load_would_touch():
    """A box that ends under the arm and over the load's lower edge: the robot alone passes over it."""
    box = Body("box", (Solid(Shape.BOX, (0.2, 0.2, 0.83), at(0.6, 0.0, 0.415)),))
    (load,) = loads_of(map_with(CarriedPiece("r", (0.0, 0.0, -0.08), (0.0, 0.0, 0.0, 1.0))), {"debris_1": PIECE}, 0.08)
    held = {}
    for name, points in (("empty", ROBOT), ("loaded", with_loads("r", ROBOT, [load]))):
        monitor, held[name] = Monitor(SafetyParams(stop_clearance_m=0.01)), []
        for i, x in enumerate(np.arange(0.0, 0.5, 1.0 / 30.0)):
            seen = {"r": Seen(Pose2(x, 0.0), HEIGHT, points, Pose2(1.0, 0.0), "g")}
            held[name].append(monitor.look(i / 30.0, seen, {"r": [box]})["r"].held)
    assert not any(held["empty"])
    assert any(held["loaded"])


def test_a_hand_at_work_is_not_stopped_for_the_last_centimetre_that_nobody_drives():
    """Beside another piece, with its own on the cup and its goal, the place over it, not yet done."""
    neighbour = Body("debris_2", (Solid(Shape.BOX, (0.06, 0.15, 0.04), at(0.115, 0.0, 0.81)),))
    (load,) = loads_of(map_with(CarriedPiece("r", (0.0, 0.0, -0.08), (0.0, 0.0, 0.0, 1.0))), {"debris_1": PIECE}, 0.08)
    points = with_loads("r", ROBOT, [load])

    def held(off_m):
        seen = {"r": Seen(Pose2(0.0, 0.0), HEIGHT, points, Pose2(off_m, 0.0), "g")}
        return Monitor(SafetyParams()).look(0.0, seen, {"r": [neighbour]})["r"].held

    assert not held(0.009)
    assert held(0.05)

"""Who of a scene is there follows from the frames that are heard, and from what a person says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.geometry import CellMap, GridSpec, transform_matrix
from yarm.geometry.cell_map import MappedObject, SeenPiece
from yarm.ros.registry.pieces import VIEWS, NamedPieces, named_piece
from yarm.ros.registry.roster import HeardFrame, Roster
from yarm.sim.scenes.bodies import SpawnError, scene_bodies
from yarm.sim.scenes.scene import load_scene, without_shapes
from yarm.sim.scenes.specs import ThingSpec

ROBOT, ARM = "ankurbot_1", "hc10_barc"
SCENE = load_scene("1m1ma")
PIECE = ThingSpec("debris_1", "Debris", -0.2, 0.1, 0.72, 0.3)
NOWHERE = np.eye(4)


def moved(parent="world", stamp_s=10.0, pose=NOWHERE):
    return HeardFrame(parent, stamp_s, pose)


@pytest.fixture
def roster():
    return Roster("world", scene_bodies(SCENE), silent_s=1.0)


def hear_all(roster, name, stamp_s):
    (body,) = (body for body in scene_bodies(SCENE) if body.name == name)
    for frame in body.frames:
        roster.hear(frame, moved(stamp_s=stamp_s))


def present(roster, now_s):
    return [body.name for body in roster.present(now_s)]


def test_what_is_bolted_down_is_there_and_its_frames_are_told(roster):
    assert present(roster, 10.0) == ["table", "stand"]
    assert set(roster.own_frames()) == {"table", "stand", f"{ARM}/base_link"}
    assert "no transform from world to" in {a.name: a.reason for a in roster.absent(10.0)}[ROBOT]


def test_a_robot_comes_with_its_frames_and_goes_with_them(roster):
    roster.hear(f"{ROBOT}/base_link", moved())
    assert ROBOT not in present(roster, 10.0), "one of two frames"
    roster.hear(f"{ROBOT}/ee", moved())
    assert ROBOT in present(roster, 10.9)
    assert ROBOT not in present(roster, 11.1)
    (absence,) = (a for a in roster.absent(11.1) if a.name == ROBOT)
    assert absence.reason == f"{ROBOT}/ee was last told 1.1 s ago, at most 1 s"
    hear_all(roster, ROBOT, 11.0)
    assert ROBOT in present(roster, 11.1)
    roster.forget()
    assert ROBOT not in present(roster, 11.1)


def test_frames_that_not_everybody_can_use_are_named(roster):
    roster.hear(f"{ROBOT}/base_link", moved())
    roster.hear(f"{ROBOT}/ee", moved(parent=f"{ROBOT}/base_link"))
    assert ROBOT not in present(roster, 10.0)
    (absence,) = (a for a in roster.absent(10.0) if a.name == ROBOT)
    assert absence.reason.startswith(f"{ROBOT}/ee is told in {ROBOT}/base_link; the frames of robots and arms must")


def test_an_arm_stands_on_the_base_that_the_scene_gives_it(roster):
    hear_all(roster, ARM, 10.0)
    assert ARM in present(roster, 10.0)
    assert f"{ARM}/base_link" not in roster.own_frames(), "its driver tells it"
    bare = Roster("world", scene_bodies(SCENE), silent_s=1.0)
    (arm,) = (body for body in scene_bodies(SCENE) if body.name == ARM)
    for frame in set(arm.frames) - {f"{ARM}/base_link"}:
        bare.hear(frame, moved())
    assert ARM in present(bare, 10.0)
    assert f"{ARM}/base_link" in bare.own_frames()


def test_a_frame_that_is_fixed_elsewhere_is_named(roster):
    true = roster.own_frames()["table"]
    roster.hear("table", moved(stamp_s=math.inf, pose=true))
    assert roster.told_elsewhere() == []
    roster.hear("table", moved(stamp_s=math.inf, pose=true @ transform_matrix((0.05, 0, 0), (0, 0, 0, 1))))
    (fault,) = roster.told_elsewhere()
    assert fault.startswith("table: /tf_static has it 0.050 m and 0.0 deg from where the scene has it")


def test_a_person_names_a_piece_and_takes_it_out(roster):
    roster.add(named_piece(PIECE))
    assert roster.named == ("debris_1",)
    assert "debris_1" in present(roster, 10.0)
    assert roster.own_frames()["debris_1"][:3, 3] == pytest.approx([-0.2, 0.1, 0.72])
    with pytest.raises(SpawnError, match="name 'debris_1' is taken; in the cell: ankurbot_1, debris_1, hc10_barc"):
        roster.add(named_piece(PIECE))
    roster.remove("debris_1")
    assert roster.named == ()
    with pytest.raises(SpawnError, match="nobody of that name is in the cell"):
        roster.remove("debris_1")
    with pytest.raises(SpawnError, match="a Mobile with drivers stays; removable: stand, table"):
        roster.remove(ROBOT)


def test_a_piece_is_followed_to_where_it_is_seen(roster):
    roster.add(named_piece(PIECE))
    before = {body.name: body for body in roster.present(10.0)}
    assert not roster.follow("debris_1", (-0.2, 0.1, 0.725))
    assert not roster.follow("table", (0.0, 0.0, 0.0)), "only debris is"
    assert roster.follow("debris_1", (-0.15, 0.05, 0.73))
    after = {body.name: body for body in roster.present(10.0)}
    assert after["debris_1"] is not before["debris_1"]
    assert after["table"] is before["table"]
    assert roster.own_frames()["debris_1"][:3, 3] == pytest.approx([-0.15, 0.05, 0.73])


def map_with(place, stamp_s):
    piece = None if place is None else SeenPiece(20, place, 0.0, 0.1, 0.05, (1, 2))
    cells = np.zeros((1, 3), dtype=np.int64)
    thing = MappedObject("debris_1", "Debris", 7, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), cells, piece)
    return CellMap(stamp_s, GridSpec(), np.zeros(GridSpec().shape, dtype=np.int8), {"debris_1": thing})


def test_the_median_of_half_a_second_counts_and_silence_is_told():
    pieces = NamedPieces()
    pieces.keep(["debris_1"], 10.0)
    rng = np.random.default_rng(1)
    for k in range(VIEWS - 1):
        x = 0.5 if k == 3 else -0.2 + rng.normal(0.0, 0.002)
        assert list(pieces.see(map_with((x, 0.1, 0.72), 10.0 + k / 30))) == []
    ((name, place),) = pieces.see(map_with((-0.2, 0.1, 0.72), 10.5))
    assert (name, place) == ("debris_1", pytest.approx((-0.2, 0.1, 0.72), abs=0.003))
    assert list(pieces.see(map_with(None, 12.0))) == []
    assert pieces.unseen(13.4, 3.0) == []
    ((name, passed_s),) = pieces.unseen(13.6, 3.0)
    assert (name, passed_s) == ("debris_1", pytest.approx(3.1))
    pieces.keep([], 13.6)
    assert pieces.unseen(20.0, 3.0) == []


def test_a_robot_without_shapes_needs_and_tells_its_frames_alone():
    (robot,) = (body for body in scene_bodies(without_shapes(SCENE)) if body.name == ROBOT)
    assert not robot.drawn
    assert robot.frames == (f"{ROBOT}/ee", f"{ROBOT}/base_link")
    assert robot.solids, "the cameras of a simulation still see them"

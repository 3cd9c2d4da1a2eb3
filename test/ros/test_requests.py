"""What people ask of nodes, before anything is done: objects to spawn, solids to calibrate by, launch words."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, Quaternion
from yarm.msg import RegisteredObject
from yarm.srv import SpawnObstaclesRequest

from yarm.geometry import quaternion_from_rpy
from yarm.geometry.solids import Shape, Solid
from yarm.ros.common import names
from yarm.ros.common.requests import DEFAULT_BOX_M, spawn_spec
from yarm.ros.common.solids import primitive_of
from yarm.ros.controls.mobile import boxes_in_base, target_pose
from yarm.sim.scenes.bodies import SpawnError

FOLDER = Path(__file__).resolve().parent


def request(**changes) -> SpawnObstaclesRequest:
    return SpawnObstaclesRequest(**{"name": "box_1", "type": "Obstacle", "x": 0.5, "y": -1.0, "z": 0.2, **changes})


def test_a_box_without_a_shape_has_the_usual_size():
    spec = spawn_spec(request(yaw=0.4), FOLDER)
    assert (spec.name, spec.kind, spec.size, spec.registered) == ("box_1", "Obstacle", tuple(DEFAULT_BOX_M), True)
    assert (spec.x, spec.y, spec.z, spec.yaw_rad) == (0.5, -1.0, 0.2, 0.4)


@pytest.mark.parametrize(
    ("kind", "expected", "registered"),
    [
        ("Debris", "Debris", True),
        ("Target", "Target", True),
        ("Unregistered", "Obstacle", False),
        ("UnregisteredDebris", "Debris", False),
    ],
)
def test_kinds_of_things(kind, expected, registered):
    spec = spawn_spec(request(type=kind, shape=[0.1, 0.2, 0.3]), FOLDER)
    assert (spec.kind, spec.registered) == (expected, registered)
    assert spec.size == ((0.1, 0.2, 0.3) if expected == "Obstacle" else ())


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"name": ""}, "name '' must be letters"),
        ({"name": "a/b"}, "name 'a/b' must be letters"),
        ({"type": "Robot"}, "type 'Robot' must be one of Debris, Target, Obstacle, Unregistered"),
        ({"x": 2.6}, "x 2.6 must be within -2.5 to 2.5"),
        ({"y": math.nan}, "y nan must be within"),
        ({"z": -0.1}, "z -0.1 must be within 0 to 1.3"),
        ({"yaw": 8.0}, "yaw 8.0 must be within"),
        ({"shape": [0.1, 0.2]}, r"shape \[0.1, 0.2\] must be three sizes within 0.01 to 5 m"),
        ({"shape": [0.1, 0.2, 0.0]}, "must be three sizes"),
        ({"shape": [0.1, 0.2, math.inf]}, "must be three sizes"),
    ],
)
def test_what_cannot_be_spawned_is_refused_with_what_is_accepted(changes, words):
    with pytest.raises(SpawnError, match=words):
        spawn_spec(request(**changes), FOLDER)


def test_a_thing_is_drawn_from_a_description_beside_the_scene_or_anywhere(tmp_path):
    (tmp_path / "barrel.urdf").write_text("<robot name='barrel'/>")
    for model in ("barrel.urdf", str(tmp_path / "barrel.urdf")):
        for kind in ("Obstacle", "Unregistered", "Debris"):
            spec = spawn_spec(request(type=kind, model=model), tmp_path)
            assert (spec.model, spec.size) == (str(tmp_path / "barrel.urdf"), ())


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"model": "none.urdf"}, "model 'none.urdf' must be a URDF or xacro file; there is no .*/none.urdf"),
        ({"model": "test_requests.py", "shape": [0.1, 0.1, 0.1]}, "must be empty where a model is given"),
        ({"model": "../data/golden_sets.npz"}, "has [0-9]{6,} bytes, at most 100000"),
        ({"model": "test_requests.py", "type": "Target"}, "a target has no body"),
    ],
)
def test_a_model_that_cannot_be_is_refused(changes, words):
    with pytest.raises(SpawnError, match=words):
        spawn_spec(request(**changes), FOLDER)


def test_all_faults_of_a_request_are_told_at_once():
    with pytest.raises(SpawnError) as error:
        spawn_spec(request(name="?", type="?", x=9.0, shape=[9.0]), FOLDER)
    assert str(error.value).count(";") == 2  # a shape is looked at only where the type has one


def test_only_solids_in_the_base_frame_count_for_calibration():
    base = names.base_frame("ankurbot_1")
    solids = [Solid(Shape.CYLINDER, (0.35, 0.45), None), Solid(Shape.BOX, (1.3, 0.08, 0.08), None)]
    turned = Pose(Point(0.65, 0.0, 0.9), Quaternion(*quaternion_from_rpy(0.0, 0.0, math.pi / 2)))
    entry = RegisteredObject(
        shapes=[primitive_of(solid) for solid in solids],
        shape_poses=[Pose(Point(0.0, 0.0, 0.3), Quaternion(0.0, 0.0, 0.0, 1.0)), turned],
        shape_frames=[base, base],
    )
    body, arm = boxes_in_base(entry, "ankurbot_1")
    assert np.concatenate(body) == pytest.approx((-0.35, -0.35, 0.075, 0.35, 0.35, 0.525))
    assert np.concatenate(arm) == pytest.approx((0.61, -0.65, 0.86, 0.69, 0.65, 0.94))
    entry.shape_frames[1] = "ankurbot_1/somewhere_else"
    assert len(boxes_in_base(entry, "ankurbot_1")) == 1


def test_a_target_is_taken_in_the_plane():
    pose = target_pose(Pose(Point(1.0, 2.0, 3.0), Quaternion(*quaternion_from_rpy(0.0, 0.0, -2.0))))
    assert (pose.x, pose.y, pose.yaw_rad) == pytest.approx((1.0, 2.0, -2.0))


@pytest.mark.parametrize("frame", [names.base_frame, names.move_robot, names.cmd_vel, names.joint_states])
def test_names_of_robots_are_relative_and_begin_with_the_robot(frame):
    assert frame("ankurbot_7").startswith("ankurbot_7/")

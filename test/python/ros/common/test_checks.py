"""Faulty messages of every kind the Python nodes listen to: named by what is wrong, never taken, never raised at."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Point, Pose, TransformStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_msgs.msg import JointState, PointCloud2, PointField
from shape_msgs.msg import SolidPrimitive
from yarm.msg import (
    GridIndex,
    GridIndexVector,
    KeepOff,
    MapMetaData,
    ObjectRegistry,
    RegisteredObject,
    SafetyStatus,
    SanderStatus,
    SimStatus,
    StepAck,
    TrackedObject,
    TrackedObjects,
    TransformStampedVector,
)

from yarm.ros.common import checks
from yarm.ros.common.conversions import parse_map_metadata

NOW_S = 100.0
FAULTY_NUMBERS = [
    ({"x": math.nan}, "must be finite"),
    ({"x": math.inf}, "must be finite"),
    ({"x": 1e9}, "within 1000 m"),
    ({"qw": 0.0}, "must have length 1, it has 0.000"),
    ({"qw": math.nan}, "must have length 1"),
]


def stamped(x=0.0, qw=1.0, stamp_s=NOW_S - 0.05, name="ankurbot_1"):
    transform = TransformStamped(child_frame_id=f"{name}/ee")
    transform.header.stamp = rospy.Time.from_sec(stamp_s)
    transform.transform.translation.x, transform.transform.rotation.w = x, qw
    return transform


def map_message(stamp_s=NOW_S - 0.05, shape=(50, 50, 20), cells=((1, 2, 3),), n_values=None, name="box", **numbers):
    message = MapMetaData(gx=shape[0], gy=shape[1], gz=shape[2])
    message.header.stamp = rospy.Time.from_sec(stamp_s)
    message.xmin, message.xmax, message.ymin, message.ymax, message.zmin, message.zmax = -2.5, 2.5, -2.5, 2.5, 0.01, 1.3
    message.frames, message.UIDs, message.objects = ["ankurbot_1", name], [1, 2], ["Mobile", "Obstacle"]
    message.seed_poses = [stamped(**numbers), stamped()]
    indices = [GridIndex(*cell) for cell in cells]
    message.grid_indices = [GridIndexVector(indices), GridIndexVector([])]
    values = shape[0] * shape[1] * shape[2] if n_values is None else n_values
    message.grid = [0] * values
    return message


def bytes_of(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def map_fault(message, before=None):
    try:
        return checks.map_fault(parse_map_metadata(bytes_of(message)), NOW_S, before)
    except ValueError as error:
        return str(error)


def test_a_good_map_is_taken():
    good = parse_map_metadata(bytes_of(map_message()))
    assert checks.map_fault(good, NOW_S, None) == ""
    assert map_fault(map_message(stamp_s=NOW_S), good) == ""


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (map_message(n_values=10), "the grid has 10 values, its shape (50, 50, 20) needs 50000"),
        (map_message(stamp_s=NOW_S + 3600.0), "its stamp 3700.000 s is in the future; it is 100.000 s"),
        (map_message(shape=(-5, 50, 20), n_values=0), "must be three whole numbers >= 1"),
        (map_message(cells=((50, 2, 3),)), "ankurbot_1 has cells outside the grid"),
        (map_message(cells=((0, -1, 3),)), "ankurbot_1 has cells outside the grid"),
        (map_message(name="ankurbot_1"), "more than one object is called ankurbot_1"),
        *((map_message(**numbers), said) for numbers, said in FAULTY_NUMBERS),
    ],
)
def test_a_faulty_map_is_named(message, said):
    assert said in map_fault(message)


def test_values_that_mean_nothing_are_refused():
    message = map_message()
    message.grid[7] = 9
    assert "must be 0, 1 or 2" in map_fault(message)


def test_another_grid_or_an_older_map_is_refused_while_maps_come():
    good = parse_map_metadata(bytes_of(map_message()))
    other = map_message(shape=(10, 1, 1), cells=())
    assert "is not the one in use" in map_fault(other, good)
    assert map_fault(other) == ""
    assert "older than that of the newest map" in map_fault(map_message(stamp_s=NOW_S - 9.0), good)


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_bytes_from_nowhere_are_a_value_error_or_a_map(data):
    raw = bytearray(bytes_of(map_message(shape=(4, 4, 2), cells=((1, 2, 1),))))
    for _ in range(data.draw(st.integers(1, 8))):
        raw[data.draw(st.integers(0, len(raw) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(raw)))
    try:
        found = parse_map_metadata(bytes(raw[:cut] if cut % 3 else raw))
    except ValueError:
        return
    for thing in found.objects.values():
        assert np.all(found.spec.contains(thing.cells))
    checks.map_fault(found, NOW_S, None)


@pytest.mark.parametrize(("numbers", "said"), FAULTY_NUMBERS)
def test_a_faulty_transform_names_its_frame(numbers, said):
    fault = checks.transform_fault(stamped(**numbers), NOW_S)
    assert fault.startswith("frame 'ankurbot_1/ee': ")
    assert said in fault


def test_a_transform_of_the_future_is_refused_unless_time_is_unknown():
    assert "in the future" in checks.transform_fault(stamped(stamp_s=NOW_S + 1.0), NOW_S)
    assert checks.transform_fault(stamped(stamp_s=NOW_S + 1.0), 0.0) == ""
    assert checks.transform_fault(stamped(), NOW_S) == ""


def registered(name="box", kind="Obstacle", sizes=(0.1, 0.1, 0.1), qw=1.0, frames=1):
    pose = Pose()
    pose.orientation.w = qw
    shape = SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(sizes))
    return RegisteredObject(
        name=name, object=kind, shapes=[shape], shape_poses=[pose], shape_frames=["f"] * frames, seed_frame="f"
    )


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ([registered(), registered()], "more than one object is called box"),
        ([registered(kind="Alien")], "object 'box' is a 'Alien', expected one of Mobile"),
        ([registered(sizes=(0.1,))], "expected 3 sizes above 0 m"),
        ([registered(sizes=(0.1, math.nan, 0.1))], "expected 3 sizes above 0 m"),
        ([registered(sizes=(0.1, -0.1, 0.1))], "expected 3 sizes above 0 m"),
        ([registered(qw=0.0)], "box: quaternion"),
        ([registered(frames=2)], "differ in length: (1, 1, 2)"),
    ],
)
def test_a_faulty_registry_is_named(entries, said):
    assert said in checks.registry_fault(ObjectRegistry(entries=entries))


def test_a_good_registry_is_taken():
    assert checks.registry_fault(ObjectRegistry(entries=[registered(), registered("ankurbot_1", "Mobile")])) == ""


def test_safety_status_needs_equal_lengths_and_no_future():
    good = SafetyStatus(robots=["a"], clearance_m=[1.0], nearest=[""], stopped=[False])
    good.header.stamp = rospy.Time.from_sec(NOW_S)
    assert checks.safety_fault(good, NOW_S) == ""
    assert "differ in length: (1, 0, 0, 0)" in checks.safety_fault(SafetyStatus(robots=["a"]), NOW_S)
    good.header.stamp = rospy.Time.from_sec(NOW_S + 60.0)
    assert "in the future" in checks.safety_fault(good, NOW_S)


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ({}, ""),
        ({"age_s": -1.0}, "object 1: age_s must be at least 0, it is -1"),
        ({"age_s": math.nan}, "object 1: age_s must be at least 0, it is nan"),
        ({"covariance": [1e9] * 36}, "object 1: position, velocity, extent and covariance must be within 1000"),
        ({"covariance": [math.nan] * 36}, "object 1: position, velocity, extent and covariance must be within 1000"),
    ],
)
def test_what_is_followed_needs_finite_numbers(fault, said):
    one = TrackedObject(**{"id": 1, "covariance": [0.01] * 36, "age_s": 1.0, **fault})
    message = TrackedObjects(objects=[one])
    message.header.stamp = rospy.Time.from_sec(NOW_S)
    assert checks.tracks_fault(message, NOW_S) == said
    assert checks.tracks_fault(TrackedObjects(objects=[one, one]), NOW_S).startswith("ids must be unique: [1, 1]")


def test_seeds_need_equal_lengths_unique_names_and_no_future():
    def seeds(names, stamp_s=NOW_S):
        message = TransformStampedVector(
            transforms=[stamped(name=n) for n in names], frame=list(names), type=["dynamic"] * len(names)
        )
        message.object = ["Mobile"] * len(names)
        message.header.stamp = rospy.Time.from_sec(stamp_s)
        return message

    assert checks.seeds_fault(seeds(["a", "b"]), NOW_S) == ""
    assert "must be unique" in checks.seeds_fault(seeds(["a", "a"]), NOW_S)
    assert "in the future" in checks.seeds_fault(seeds(["a"], NOW_S + 9.0), NOW_S)
    short = seeds(["a", "b"])
    short.object = ["Mobile"]
    assert "differ in length" in checks.seeds_fault(short, NOW_S)


def test_joints_need_finite_positions_and_no_future():
    good = JointState(name=["j"], position=[0.1])
    good.header.stamp = rospy.Time.from_sec(NOW_S)
    assert checks.joints_fault(good, NOW_S) == ""
    assert "positions of j are not finite" in checks.joints_fault(JointState(name=["j"], position=[math.nan]), NOW_S)
    assert "1 names but 0 positions" in checks.joints_fault(JointState(name=["j"]), NOW_S)
    good.header.stamp = rospy.Time.from_sec(NOW_S + 60.0)
    assert "in the future" in checks.joints_fault(good, NOW_S)


def test_a_sander_has_six_states():
    assert checks.sander_fault(SanderStatus(state=5), NOW_S) == ""
    assert "state 9 must be one of [0, 1, 2, 3, 4, 5]" in checks.sander_fault(SanderStatus(state=9), NOW_S)


def test_a_cloud_must_be_as_long_as_it_says_and_hold_x_y_z():
    fields = [PointField(name=n, offset=4 * i, datatype=7, count=1) for i, n in enumerate("xyz")]
    good = PointCloud2(width=2, height=3, point_step=16, data=bytes(96), fields=fields)
    assert checks.cloud_fault(good) == ""
    assert "96 bytes for 2 x 4 points" in checks.cloud_fault(
        PointCloud2(width=2, height=4, point_step=16, data=bytes(96), fields=fields)
    )
    for wrong in (fields[:2], fields[::-1][:1], []):
        assert "must hold x, y, z" in checks.cloud_fault(
            PointCloud2(width=2, height=3, point_step=16, data=bytes(96), fields=wrong)
        )


@pytest.mark.parametrize(("sender", "taken"), [("/commander", True), ("/cell/commander", True), ("/stranger", False)])
def test_an_acknowledgement_counts_only_from_its_own_node(sender, taken):
    ack = StepAck(node="commander", commands_sent=10**6)
    ack._connection_header = {"callerid": sender}
    assert (checks.ack_fault(ack) == "") is taken


@pytest.mark.parametrize(
    ("said", "fault"),
    [
        ({"touched": ["ankurbot_1 debris_2"], "debris": ["debris_1"], "bins": [""]}, ""),
        ({"touched": ["ankurbot_1 debris_2", "ankurbot_1"]}, "pairs of bodies, 'a b'; there is 'ankurbot_1'"),
        ({"touched": ["a b c"]}, "there is 'a b c'"),
        ({"touched": [""]}, "there is ''"),
        ({"debris": ["debris_1", "debris_2"], "bins": [""]}, "2 pieces of debris, but 1 bins"),
    ],
)
def test_what_the_simulator_says_of_its_bodies_is_pairs(said, fault):
    found = checks.sim_fault(SimStatus(**said))
    assert fault in found if fault else found == ""


@pytest.mark.parametrize(
    ("points", "distance", "fault"),
    [
        ([(0.1, -0.2)], 0.4, ""),
        ([], 0.0, ""),
        ([(math.nan, 0.0)], 0.4, "must be finite"),
        ([(0.0, 1e9)], 0.4, "within 1000 m"),
        ([(0.0, 0.0)], -0.1, "(-0.1 m)"),
        ([(0.0, 0.0)], math.nan, "(nan m)"),
        ([(0.0, 0.0)] * 10001, 0.4, "10001 points to keep off, at most 10000"),
    ],
)
def test_what_a_tip_keeps_off_is_places(points, distance, fault):
    found = checks.keep_off_fault(KeepOff([Point(x, y, math.nan) for x, y in points], distance))
    assert fault in found if fault else found == ""


def test_the_door_names_the_sender_and_does_not_repeat_itself(monkeypatch):
    said = []
    monkeypatch.setattr(checks.rospy, "logwarn", lambda text, *values: said.append(text % values))
    door = checks.Doorkeeper("planning_metadata")
    message = MapMetaData()
    message._connection_header = {"callerid": "/stranger"}
    assert not door.refuses(message, "")
    assert door.refuses(message, "the grid has 10 values")
    assert door.refuses(message, "the grid has 10 values")
    assert said == ["planning_metadata of stranger refused: the grid has 10 values"]

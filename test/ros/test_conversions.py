"""Messages to core types and back, against the messages' own serialisation."""

from __future__ import annotations

import math
from io import BytesIO

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Transform, TransformStamped, Vector3
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from yarm.msg import CarriedPiece as CarriedMessage
from yarm.msg import GridIndex, GridIndexVector, MapMetaData, PieceView

from yarm.geometry import CarriedPiece, SeenPiece, quaternion_from_rpy, rotation_of_quaternion, transform_matrix
from yarm.geometry.poses import quaternions_of
from yarm.ros.commander.reports import exact_time
from yarm.ros.common.conversions import (
    matrix_of_pose,
    matrix_of_transform,
    parse_map_metadata,
    pose2_of_transform,
    pose_message,
)
from yarm.ros.simulation.clouds import RawCloud, RawTransforms
from yarm.sim.sensors.camera_model import CLOUD_DTYPE

angles = st.floats(-math.pi, math.pi)
BYTES_OF_NO_VISIBILITY = 12
"""Three empty arrays at the end of a serialised MapMetaData."""


def serialised(message) -> bytes:
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def metadata(**changes) -> MapMetaData:
    """A grid of 2 x 3 x 4 cells with a robot and a box."""
    grid = np.zeros((2, 3, 4), dtype=np.int8)
    grid[0, 1, 2] = grid[1, 2, 3] = 1
    seed = TransformStamped(transform=Transform(Vector3(0.1, 0.2, 0.9), Quaternion(0.0, 0.0, 1.0, 0.0)))
    seed.header.frame_id = "world"
    fields = {
        "header": Header(7, rospy.Time(12, 500000000), "world"),
        "gx": 2,
        "gy": 3,
        "gz": 4,
        "xmin": -1.0,
        "xmax": 1.0,
        "ymin": -1.5,
        "ymax": 1.5,
        "zmin": 0.0,
        "zmax": 2.0,
        "frames": ["ankurbot_1", "böx"],
        "UIDs": [3, 9],
        "objects": ["Mobile", "Obstacle"],
        "seed_poses": [seed, TransformStamped()],
        "grid_indices": [GridIndexVector([GridIndex(0, 1, 2)]), GridIndexVector([])],
        "grid": grid.reshape(-1).tolist(),
        "collisions": [],
    }
    return MapMetaData(**{**fields, **changes})


def test_a_grid_is_read_from_its_bytes():
    found = parse_map_metadata(serialised(metadata()))
    assert found.stamp_s == 12.5
    assert found.spec.shape == (2, 3, 4)
    assert (found.spec.lower, found.spec.upper) == ((-1.0, -1.5, 0.0), (1.0, 1.5, 2.0))
    assert np.argwhere(found.grid).tolist() == [[0, 1, 2], [1, 2, 3]]
    assert list(found.objects) == ["ankurbot_1", "böx"]
    robot = found.objects["ankurbot_1"]
    assert (robot.kind, robot.uid, robot.cells.tolist()) == ("Mobile", 3, [[0, 1, 2]])
    assert robot.position_m == (0.1, 0.2, 0.9) and robot.quaternion == (0.0, 0.0, 1.0, 0.0)
    assert found.objects["böx"].cells.shape == (0, 3)
    assert all(thing.piece is None for thing in found.objects.values())


def test_what_is_seen_of_debris_is_read_after_the_collisions():
    seen = PieceView("böx", 42, Point(0.1, -0.2, 0.77), 0.5, 0.15, 0.06, 0b101)
    found = parse_map_metadata(serialised(metadata(pieces=[seen], collisions=[GridIndex(0, 1, 2)])))
    assert found.objects["böx"].piece == SeenPiece(42, (0.1, -0.2, 0.77), 0.5, 0.15, 0.06, (1, 3))
    assert found.objects["ankurbot_1"].piece is None


def test_what_is_carried_is_read_after_the_pieces():
    pose = Pose(Point(0.01, -0.02, -0.1), Quaternion(0.0, 0.0, 1.0, 0.0))
    seen = PieceView("böx", 42, Point(0.1, -0.2, 0.77), 0.5, 0.15, 0.06, 0b101)
    how = [CarriedMessage("böx", "ankurbot_1", pose)]
    found = parse_map_metadata(serialised(metadata(carried=how, pieces=[seen])))
    assert found.objects["böx"].carried == CarriedPiece("ankurbot_1", (0.01, -0.02, -0.1), (0.0, 0.0, 1.0, 0.0))
    assert found.objects["ankurbot_1"].carried is None


@pytest.mark.parametrize(
    ("how", "words"),
    [
        (CarriedMessage("nobody", "ankurbot_1", Pose()), "'nobody' is not on the map"),
        (CarriedMessage("böx", "nobody", Pose()), "'nobody' is not on the map"),
        (CarriedMessage("böx", "ankurbot_1", Pose(Point(math.nan, 0.0, 0.0), Quaternion())), "böx is carried must be"),
    ],
)
def test_a_load_that_makes_no_sense_is_refused(how, words):
    with pytest.raises(ValueError, match=words):
        parse_map_metadata(serialised(metadata(carried=[how])))


@pytest.mark.parametrize(
    ("seen", "words"),
    [
        (
            PieceView("nobody", 42, Point(0.1, -0.2, 0.77), 0.5, 0.1, 0.06, 0),
            "'nobody' is seen, which is not on the map",
        ),
        (PieceView("böx", 42, Point(math.nan, -0.2, 0.77), 0.5, 0.15, 0.06, 0), "böx must be finite"),
        (PieceView("böx", 42, Point(0.1, -0.2, 0.77), 0.5, math.inf, 0.06, 0), "böx must be finite"),
    ],
)
def test_a_piece_that_makes_no_sense_is_refused(seen, words):
    with pytest.raises(ValueError, match=words):
        parse_map_metadata(serialised(metadata(pieces=[seen])))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"grid": [0] * 10}, "the grid has 10 values, its shape .* needs 24"),
        ({"UIDs": [1]}, "the arrays of objects differ in length"),
        ({"objects": ["Mobile", "Obstacle", "Debris"]}, "differ in length"),
        ({"gx": -2}, "cannot be read"),
        ({"xmax": -1.0}, "cannot be read"),
        ({"zmin": math.nan}, "cannot be read"),
    ],
)
def test_a_grid_that_contradicts_itself_is_refused_with_what_is_wrong(changes, words):
    with pytest.raises(ValueError, match=words):
        parse_map_metadata(serialised(metadata(**changes)))


def test_bytes_that_end_too_early_are_refused_wherever_they_end():
    data = serialised(metadata())
    for end in set(range(0, len(data), 7)) - {len(data) - BYTES_OF_NO_VISIBILITY}:
        with pytest.raises(ValueError, match=f"planning_metadata of {end} bytes cannot be read"):
            parse_map_metadata(data[:end])


STATES = [2] * 22 + [1, 0]


def test_what_the_cameras_see_of_the_cells_is_read_after_the_carried_pieces():
    ages = [0.0] * 22 + [1.5, math.inf]
    sight = parse_map_metadata(serialised(metadata(visibility=STATES, hidden_by=[1 << 31, 2], age_s=ages))).visibility
    assert sight is not None and sight.age_s is not None
    assert sight.states.shape == sight.age_s.shape == (2, 3, 4)
    assert np.argwhere(sight.unseen).tolist() == [[1, 2, 2], [1, 2, 3]]
    assert sight.hidden_by.tolist() == [1 << 31, 2]
    assert sight.age_s[1, 2, 2:].tolist() == [1.5, math.inf]
    without_ages = parse_map_metadata(serialised(metadata(visibility=STATES, hidden_by=[1, 2]))).visibility
    assert without_ages is not None and without_ages.age_s is None


def test_a_map_without_visibility_is_whole_and_so_is_one_from_before_there_was_any():
    data = serialised(metadata())
    assert parse_map_metadata(data).visibility is None
    old = parse_map_metadata(data[:-BYTES_OF_NO_VISIBILITY])
    assert old.visibility is None and list(old.objects) == ["ankurbot_1", "böx"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"visibility": STATES[:-1], "hidden_by": [1]}, "visibility has 23 values, the grid of .* needs 24 or none"),
        ({"visibility": [*STATES[:-1], 4], "hidden_by": [1]}, "visibility's values 1 to 4 must be 0 to 3"),
        ({"visibility": [*STATES[:-1], -1], "hidden_by": [1]}, "visibility's values -1 to 2 must be 0 to 3"),
        ({"visibility": STATES, "hidden_by": [1]}, "hidden_by has 1 values for 2 cells that are not seen"),
        ({"hidden_by": [1]}, "hidden_by has 1 values for 0 cells"),
        ({"visibility": STATES, "hidden_by": [1, 1], "age_s": [0.0]}, "age_s has 1 values, the grid of .* needs 24"),
        ({"visibility": STATES, "hidden_by": [1, 1], "age_s": [math.nan] * 24}, "age_s must be 0 or more"),
        ({"visibility": STATES, "hidden_by": [1, 1], "age_s": [-1.0] * 24}, "age_s must be 0 or more"),
    ],
)
def test_visibility_that_makes_no_sense_is_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        parse_map_metadata(serialised(metadata(**changes)))


@given(st.floats(-9, 9), st.floats(-9, 9), st.floats(-9, 9), angles)
def test_a_pose_message_stands_where_it_is_told(x, y, z, yaw_rad):
    matrix = matrix_of_pose(pose_message(x, y, z, yaw_rad))
    assert matrix == pytest.approx(transform_matrix((x, y, z), quaternion_from_rpy(0.0, 0.0, yaw_rad)), abs=1e-9)


def test_a_transform_and_a_pose_of_the_same_numbers_are_the_same():
    q = Quaternion(*quaternion_from_rpy(0.1, 0.2, 0.3))
    pose, transform = Pose(Point(1.0, 2.0, 3.0), q), Transform(Vector3(1.0, 2.0, 3.0), q)
    assert matrix_of_pose(pose) == pytest.approx(matrix_of_transform(transform))
    plane = pose2_of_transform(transform)
    assert (plane.x, plane.y, plane.yaw_rad) == pytest.approx((1.0, 2.0, 0.3))


@given(angles, st.floats(-1.5, 1.5), angles)
def test_quaternions_of_rotations_turn_like_them(roll, pitch, yaw):
    rotation = rotation_of_quaternion(quaternion_from_rpy(roll, pitch, yaw))
    (quaternion,) = quaternions_of(rotation[None])
    assert np.linalg.norm(quaternion) == pytest.approx(1.0)
    assert rotation_of_quaternion(quaternion) == pytest.approx(rotation, abs=1e-9)


@pytest.mark.parametrize("axis", range(3))
def test_half_turns_have_quaternions_too(axis):
    rotation = -np.eye(3)
    rotation[axis, axis] = 1.0
    assert rotation_of_quaternion(quaternions_of(rotation[None])[0]) == pytest.approx(rotation, abs=1e-12)


def test_a_raw_cloud_is_a_cloud():
    points = np.zeros((2, 3), dtype=CLOUD_DTYPE)
    points["x"] = np.arange(6).reshape(2, 3)
    points["z"][1, 2] = np.nan
    raw = RawCloud("camera_optical", 2, 3, CLOUD_DTYPE.itemsize).fill(rospy.Time(3, 5), points)
    cloud = PointCloud2().deserialize(serialised(raw))
    assert (cloud.height, cloud.width, cloud.row_step, cloud.is_bigendian) == (2, 3, 48, False)
    assert (cloud.header.frame_id, cloud.header.stamp) == ("camera_optical", rospy.Time(3, 5))
    assert np.array_equal(np.frombuffer(cloud.data, dtype=CLOUD_DTYPE)["x"], points["x"].reshape(-1))
    assert [(field.name, field.offset) for field in cloud.fields] == [("x", 0), ("y", 4), ("z", 8), ("rgb", 12)]
    assert PointCloud2().deserialize(serialised(raw.fill(rospy.Time(4), points))).header.seq == 2


def test_raw_transforms_are_transforms():
    poses = {
        "a": transform_matrix((1.0, 2.0, 3.0), quaternion_from_rpy(0.0, 0.0, 0.5)),
        "a/much_longer_name": transform_matrix((-1.0, 0.0, 0.5), quaternion_from_rpy(0.3, 0.0, 3.0)),
    }
    raw = RawTransforms(list(poses)).fill(rospy.Time(8, 9), poses)
    message = TFMessage().deserialize(serialised(raw))
    assert [transform.child_frame_id for transform in message.transforms] == list(poses)
    for transform in message.transforms:
        assert (transform.header.frame_id, transform.header.stamp) == ("world", rospy.Time(8, 9))
        assert matrix_of_transform(transform.transform) == pytest.approx(poses[transform.child_frame_id])
    assert TFMessage().deserialize(serialised(RawTransforms([]).fill(rospy.Time(1), {}))).transforms == []


@given(st.integers(0, 2**31), st.integers(0, 999999999))
def test_a_stamp_in_seconds_comes_back_to_the_microsecond(secs, nsecs):
    stamp = rospy.Time(secs, nsecs)
    assert abs((exact_time(stamp.to_sec()) - stamp).to_sec()) < 1e-6


@pytest.mark.parametrize("tick", [0, 1, 7, 59, 1800, 216001])
def test_the_stamp_of_a_tick_comes_back_exactly(tick):
    """In lock-step a stamp is a name: one nanosecond off is another tick."""
    stamp = rospy.Time(0, round(tick * 1e9 / 60.0))
    assert exact_time(stamp.to_sec()) == stamp

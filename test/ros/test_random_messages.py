"""Every check of a message from elsewhere says yes or no to anything that can be sent, and never raises."""

from __future__ import annotations

import random
import sys
from pathlib import Path
from typing import Any, Callable, Tuple, Type

import pytest
from geometry_msgs.msg import Pose, PoseStamped, TransformStamped
from sensor_msgs.msg import JointState, PointCloud2
from tf2_msgs.msg import TFMessage
from yarm.msg import (
    MapMetaData,
    MoveRobotGoal,
    ObjectRegistry,
    SafetyStatus,
    SanderStatus,
    StepAck,
    TrackedObjects,
    TransformStampedVector,
)
from yarm.srv import SpawnObstaclesRequest

from yarm.ros.common import checks
from yarm.ros.common.conversions import parse_map_metadata
from yarm.ros.common.requests import spawn_spec
from yarm.ros.controls import mobile
from yarm.sim.scenes.bodies import SpawnError

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from random_messages import random_bytes, random_message

TRIES = 1000
NOW_S = 12.0
NAMES = ("ankurbot_1", "hc10_barc")


def map_reader(message: MapMetaData, rng: random.Random) -> str:
    try:
        cell_map = parse_map_metadata(random_bytes(message, rng))
    except ValueError as error:
        return str(error)
    return checks.map_fault(cell_map, NOW_S, None)


def spawn_reader(request: SpawnObstaclesRequest, _: random.Random) -> str:
    try:
        spawn_spec(request, Path(__file__).parent)
    except SpawnError as error:
        return str(error)
    return ""


READERS: Tuple[Tuple[Type[Any], Callable[[Any, random.Random], str]], ...] = (
    (JointState, lambda m, _: checks.joints_fault(m, NOW_S)),
    (MapMetaData, map_reader),
    (MoveRobotGoal, lambda m, _: mobile.pose_fault("target", m.target) or mobile.via_fault(m)),
    (ObjectRegistry, lambda m, _: checks.registry_fault(m)),
    (PointCloud2, lambda m, _: checks.cloud_fault(m)),
    (Pose, lambda m, _: checks.pose_fault(m)),
    (SafetyStatus, lambda m, _: checks.safety_fault(m, NOW_S)),
    (SanderStatus, lambda m, _: checks.sander_fault(m, NOW_S)),
    (SpawnObstaclesRequest, spawn_reader),
    (StepAck, lambda m, _: checks.ack_fault(m)),
    (TrackedObjects, lambda m, _: checks.tracks_fault(m, NOW_S)),
    (TransformStamped, lambda m, _: checks.transform_fault(m, NOW_S)),
    (TransformStampedVector, lambda m, _: checks.seeds_fault(m, NOW_S)),
)


@pytest.mark.parametrize(("kind", "reader"), READERS, ids=[kind.__name__ for kind, _ in READERS])
def test_a_reader_refuses_or_takes_whatever_comes(kind: Type[Any], reader: Callable[[Any, random.Random], str]) -> None:
    refused = 0
    for seed in range(TRIES):
        rng = random.Random(seed)
        message = random_message(kind, rng, NAMES, NOW_S)
        try:
            refused += bool(reader(message, rng))
        except Exception as error:
            raise AssertionError(f"seed {seed}: {error!r} at {message}") from error
    assert refused > 0, "nothing was wrong with any of them"


def test_any_message_can_be_made_and_sent() -> None:
    for kind in (PoseStamped, TFMessage, MapMetaData, ObjectRegistry):
        for seed in range(20):
            message = random_message(kind, random.Random(seed), NAMES, NOW_S)
            assert random_bytes(message, random.Random(0)) is not None
            assert random_message(kind, random.Random(seed), NAMES, NOW_S)._type == message._type

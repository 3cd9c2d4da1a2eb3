"""Poses from the bytes of ``/tf``: sixty messages a second are read without an object for each transform."""

from __future__ import annotations

import struct
from typing import Callable, Dict, Iterator, Optional, Tuple, Union

import numpy as np
import rospy
from tf2_msgs.msg import TFMessage

from yarm.console.picture import Pose
from yarm.geometry import FloatArray, transform_matrix
from yarm.ros.common import names
from yarm.ros.console.routes import Route

COUNT, STAMP, NUMBERS = struct.Struct("<I"), struct.Struct("<III"), struct.Struct("<7d")


MOST_LINKS = 30
"""Between a frame and one that it hangs on; more are a circle."""


def read_transforms(data: bytes) -> Iterator[Tuple[str, str, Pose]]:
    """Parent, child and pose of each transform of a serialised tf2_msgs/TFMessage.

    Raises:
        ValueError: the bytes end too early.
    """
    try:
        (count,), at = COUNT.unpack_from(data), COUNT.size
        for _ in range(count):
            parent, at = _text(data, at + STAMP.size)
            child, at = _text(data, at)
            yield parent, child, NUMBERS.unpack_from(data, at)
            at += NUMBERS.size
    except struct.error as error:
        raise ValueError(f"a message of /tf with {len(data)} bytes cannot be read: {error}") from error


def _plain(message: TFMessage) -> Iterator[Tuple[str, str, Pose]]:
    for each in message.transforms:
        at, turn = each.transform.translation, each.transform.rotation
        pose = (at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w)
        yield each.header.frame_id.lstrip("/"), each.child_frame_id.lstrip("/"), pose


def _text(data: bytes, at: int) -> Tuple[str, int]:
    (length,) = COUNT.unpack_from(data, at)
    at += COUNT.size
    return data[at : at + length].decode("utf-8", "replace").lstrip("/"), at + length


class PoseBook:
    """The newest pose of every frame on the one it hangs on. Not thread-safe."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        """Nothing is known yet.

        Args:
            warn: takes a line about a message that cannot be read.
        """
        self._warn = warn
        self._poses: Dict[str, Pose] = {}
        self._others: Dict[str, Tuple[str, Pose]] = {}

    def routes(self) -> Dict[str, Route]:
        """What it listens to."""
        return {
            "/tf_static": Route(TFMessage, self._take, 100, raw=True),
            "/tf": Route(TFMessage, self._take, 10, raw=True),
        }

    def newest(self) -> Dict[str, Pose]:
        """Of every frame that hangs on the world, by frame; to be read only."""
        return self._poses

    def matrix(self, base: str, frame: str) -> Optional[FloatArray]:
        """The pose of a frame, (4, 4), in one that it hangs on, at whatever distance; None when it does not."""
        found = np.eye(4)
        for _ in range(MOST_LINKS):
            if frame == base:
                return found
            if frame not in self._others:
                return None
            frame, pose = self._others[frame]
            found = transform_matrix(pose[:3], pose[3:]) @ found
        return None

    def _take(self, message: Union[rospy.AnyMsg, TFMessage]) -> None:
        try:
            found = list(read_transforms(message._buff) if isinstance(message, rospy.AnyMsg) else _plain(message))
        except ValueError as error:
            self._warn(str(error))
            return
        for parent, child, pose in found:
            if parent == names.WORLD_FRAME:
                self._poses[child] = pose
            else:
                self._others[child] = (parent, pose)

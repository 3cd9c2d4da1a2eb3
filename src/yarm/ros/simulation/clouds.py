"""Messages that are sent often or are large, serialised by filling numbers into bytes made beforehand."""

from __future__ import annotations

import struct
from io import BytesIO
from typing import List, Mapping, Sequence, Tuple

import numpy as np
import numpy.typing as npt
import rospy
from sensor_msgs.msg import PointCloud2, PointField
from tf2_msgs.msg import TFMessage

from yarm.geometry import FloatArray
from yarm.geometry.poses import quaternions_of
from yarm.ros.common import names

STAMP_AT = 4
"""Offset of a header's stamp in a serialised message, after its sequence number."""


class RawCloud:
    """A PointCloud2 that is serialised from a NumPy image without being copied into a message first."""

    _type = PointCloud2._type
    _md5sum = PointCloud2._md5sum
    _full_text = PointCloud2._full_text
    _has_header = False

    def __init__(self, frame: str, height: int, width: int, point_step: int) -> None:
        """Prepare the bytes around the points."""
        message = PointCloud2(height=height, width=width, point_step=point_step, row_step=point_step * width)
        message.header.frame_id = frame
        message.fields = [
            PointField(axis, 4 * i, PointField.FLOAT32, 1) for i, axis in enumerate(("x", "y", "z", "rgb"))
        ]
        buffer = BytesIO()
        message.serialize(buffer)
        whole = buffer.getvalue()
        self._before = bytearray(whole[:-5] + struct.pack("<I", point_step * width * height))
        self._seq = 0
        self._points = memoryview(b"")

    def fill(self, stamp: rospy.Time, points: npt.NDArray[np.void]) -> RawCloud:
        """Set capture time and points; the array must not change until the message is published."""
        self._seq += 1
        struct.pack_into("<III", self._before, 0, self._seq, stamp.secs, stamp.nsecs)
        self._points = points.view(np.uint8).reshape(-1).data
        return self

    def serialize(self, buff: BytesIO) -> None:
        """Write the message; called by rospy."""
        buff.write(self._before)
        buff.write(self._points)
        buff.write(b"\x00")


class RawTransforms:
    """A TFMessage of transforms world <- frame whose set of frames seldom changes."""

    _type = TFMessage._type
    _md5sum = TFMessage._md5sum
    _full_text = TFMessage._full_text
    _has_header = False

    def __init__(self, frames: Sequence[str]) -> None:
        """Prepare the bytes for these frames."""
        self.frames: Tuple[str, ...] = tuple(frames)
        parent = names.WORLD_FRAME.encode()
        data = bytearray(struct.pack("<I", len(self.frames)))
        self._stamps: List[int] = []
        self._numbers: List[int] = []
        for frame in self.frames:
            child = frame.encode()
            self._stamps.append(len(data) + STAMP_AT)
            data += struct.pack("<III", 0, 0, 0) + struct.pack("<I", len(parent)) + parent
            data += struct.pack("<I", len(child)) + child
            self._numbers.append(len(data))
            data += bytes(56)
        self._data = data

    def fill(self, stamp: rospy.Time, poses: Mapping[str, FloatArray]) -> RawTransforms:
        """Set time and T_world_frame (4, 4) of every frame."""
        matrices = np.array([poses[frame] for frame in self.frames]).reshape(-1, 4, 4)
        values = np.concatenate([matrices[:, :3, 3], quaternions_of(matrices[:, :3, :3])], axis=1)
        for at, number_at, row in zip(self._stamps, self._numbers, values):
            struct.pack_into("<II", self._data, at, stamp.secs, stamp.nsecs)
            self._data[number_at : number_at + 56] = row.tobytes()
        return self

    def serialize(self, buff: BytesIO) -> None:
        """Write the message; called by rospy."""
        buff.write(self._data)

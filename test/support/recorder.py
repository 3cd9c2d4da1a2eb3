"""Takes whole camera sets from a simulation that waits for it in lock-step, so that a slow machine loses nothing.

    roslaunch yarm simulation.launch scene:=2m1ma sync:=true wait_for_metadata:=false set_participants:=[recorder]

``COMMAND`` is that command. The node must be called ``recorder``.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Tuple

import rospy
from geometry_msgs.msg import Twist
from rospy.msg import AnyMsg
from tf2_msgs.msg import TFMessage
from yarm.msg import StepAck

from yarm.ros import names

NODE = "recorder"
CAMERAS = (1, 2, 3, 4)
SPEED_MPS = 0.3


def command(scene: str) -> List[str]:
    """The command that starts the simulation this module records from."""
    lockstep = ["sync:=true", "wait_for_metadata:=false", f"set_participants:=[{NODE}]"]
    return ["roslaunch", "yarm", "simulation.launch", f"scene:={scene}", *lockstep]


@dataclass(frozen=True)
class WholeSet:
    """Serialised messages of one capture time: TFMessage, ObjectRegistry, and a PointCloud2 a camera."""

    stamp_ns: int
    frames: bytes
    registry: bytes
    clouds: Tuple[bytes, ...]


class Recorder:
    """Calls back with every whole set while the simulation waits, drives a robot on and lets the simulation go on."""

    def __init__(self, on_set: Callable[[WholeSet], None]) -> None:
        """Start; the callback comes on a subscriber's thread, one at a time."""
        self._on_set = on_set
        self._lock = threading.Lock()
        self._fixed: Dict[str, Any] = {}
        self._registry = b""
        self._frames: Dict[int, bytes] = {}
        self._clouds: Dict[int, Dict[int, bytes]] = {}
        self._commands = 0
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=10)
        self._drive = rospy.Publisher(names.cmd_vel("ankurbot_1"), Twist, queue_size=10)
        rospy.Subscriber("/tf_static", TFMessage, self._on_fixed)
        rospy.Subscriber("/tf", AnyMsg, self._on_tf)
        rospy.Subscriber(names.OBJECT_REGISTRY, AnyMsg, self._on_registry)
        for camera in CAMERAS:
            rospy.Subscriber(names.camera_points(camera), AnyMsg, self._on_cloud, camera, buff_size=1 << 23)

    @property
    def fixed_frames(self) -> TFMessage:
        """The fixed frames heard so far."""
        return TFMessage(list(self._fixed.values()))

    def _on_fixed(self, message: TFMessage) -> None:
        self._fixed.update({t.child_frame_id: t for t in message.transforms})

    def _on_registry(self, message: AnyMsg) -> None:
        self._registry = message._buff

    def _on_tf(self, message: AnyMsg) -> None:
        stamp = TFMessage().deserialize(message._buff).transforms[0].header.stamp
        with self._lock:
            self._frames[stamp.to_nsec()] = message._buff
            self._take(stamp.to_nsec())

    def _on_cloud(self, message: AnyMsg, camera: int) -> None:
        secs, nsecs = (int.from_bytes(message._buff[at : at + 4], "little") for at in (4, 8))
        with self._lock:
            self._clouds.setdefault(secs * 10**9 + nsecs, {})[camera] = message._buff
            self._take(secs * 10**9 + nsecs)

    def _take(self, stamp_ns: int) -> None:
        clouds = self._clouds.get(stamp_ns, {})
        if len(clouds) < len(CAMERAS) or stamp_ns not in self._frames:
            return
        whole = WholeSet(stamp_ns, self._frames[stamp_ns], self._registry, tuple(clouds[c] for c in CAMERAS))
        self._clouds.clear()
        self._frames.clear()
        self._on_set(whole)
        forward = Twist()
        forward.linear.x = SPEED_MPS
        self._drive.publish(forward)
        self._commands += 1
        ack = StepAck(node=NODE, commands_sent=self._commands)
        ack.header.stamp = rospy.Time(stamp_ns // 10**9, stamp_ns % 10**9)
        self._ack.publish(ack)

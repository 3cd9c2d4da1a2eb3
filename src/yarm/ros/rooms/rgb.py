"""What the RGB camera of a robot in a layout sees, drawn only when somebody listens."""

from __future__ import annotations

import rospy
from sensor_msgs.msg import CameraInfo, Image

from yarm.experiments.inspect.eyes import Camera
from yarm.robots.turtlebot import RGB_CAMERA
from yarm.ros.common import names
from yarm.ros.rooms.messages import pinhole_info, rgb_message
from yarm.sim.engine.room import TICK_S, RoomWorld


def frame_number(tick: int, rate_hz: float) -> int:
    """Number of the newest frame that is due at a tick."""
    return int(round(tick * TICK_S * rate_hz, 6))


class RgbOutbox:
    """Publishes frames at a rate of simulated time; a frame's noise depends on its number, not on who listened."""

    def __init__(self, world: RoomWorld, camera: Camera, rate_hz: float) -> None:
        """Advertise."""
        self._world, self._camera, self._rate_hz = world, camera, rate_hz
        self._image = rospy.Publisher(names.RGB_IMAGE, Image, queue_size=1)
        self._info = rospy.Publisher(names.RGB_INFO, CameraInfo, queue_size=1)

    def publish(self, stamp: rospy.Time) -> bool:
        """Publish what is due at this tick and listened to; whether a frame was drawn."""
        number = frame_number(self._world.ticks, self._rate_hz)
        if number == frame_number(self._world.ticks - 1, self._rate_hz):
            return False
        if self._info.get_num_connections():
            self._info.publish(pinhole_info(RGB_CAMERA, names.RGB_FRAME, stamp))
        if not self._image.get_num_connections():
            return False
        self._image.publish(rgb_message(self._camera.frame(self._world.truth, number), stamp))
        return True

"""Camera pictures of several encodings as grey ones, and grey ones as messages."""

from __future__ import annotations

from typing import Tuple

import cv2
import numpy as np
from sensor_msgs.msg import Image

from yarm.robots.turtlebot import CAMERA_HEIGHT_PX, CAMERA_WIDTH_PX
from yarm.tags.motifs import GreyImage

CHANNELS = {"mono8": 1, "8UC1": 1, "rgb8": 3, "bgr8": 3, "8UC3": 3}
"""Encodings that are taken; without further word three channels are blue, green, red, as OpenCV has them."""
NO_PICTURE: GreyImage = np.zeros((0, 0), np.uint8)


def picture_fault(message: Image) -> str:
    """What is wrong with a picture message; empty when it can be used."""
    channels = CHANNELS.get(message.encoding, 0)
    if not channels:
        return f"encoding {message.encoding!r}, expected one of {', '.join(CHANNELS)}"
    least = message.width * channels
    if message.width < 1 or message.height < 1 or message.step < least:
        return f"{message.width} x {message.height} pixels in rows of {message.step} bytes, expected at least {least}"
    if len(message.data) != message.step * message.height:
        return f"{len(message.data)} bytes for {message.height} rows of {message.step}"
    return ""


def grey_of(message: Image) -> GreyImage:
    """(h, w) grey of a picture message without faults."""
    channels = CHANNELS[message.encoding]
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    pixels = rows[:, : message.width * channels].reshape(message.height, message.width, channels)
    if channels == 1:
        return np.ascontiguousarray(pixels[..., 0])
    code = cv2.COLOR_RGB2GRAY if message.encoding == "rgb8" else cv2.COLOR_BGR2GRAY
    grey: GreyImage = cv2.cvtColor(pixels, code)
    return grey


def take_picture(message: Image) -> Tuple[GreyImage, str]:
    """Grey of a picture message and "", or an empty picture and what is wrong with the message."""
    fault = picture_fault(message)
    return (NO_PICTURE, fault) if fault else (grey_of(message), "")


def take_camera_picture(message: Image) -> Tuple[GreyImage, str]:
    """The same for the robot's own camera, whose pictures have one size: where a box must be is told in pixels."""
    grey, fault = take_picture(message)
    if not fault and grey.shape != (CAMERA_HEIGHT_PX, CAMERA_WIDTH_PX):
        height, width = grey.shape
        fault = f"{width} x {height} pixels, expected {CAMERA_WIDTH_PX} x {CAMERA_HEIGHT_PX}"
    return (NO_PICTURE, fault) if fault else (grey, "")

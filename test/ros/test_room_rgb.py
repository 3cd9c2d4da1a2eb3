"""The RGB camera's publisher: due frames, drawn only for listeners, the same frame for the same number."""

from __future__ import annotations

from typing import Any, ClassVar, Dict, List

import numpy as np
import pytest
import rospy

from yarm.experiments.inspect.eyes import Camera
from yarm.geometry import Pose2
from yarm.ros.common import names
from yarm.ros.rooms import rgb
from yarm.sim.scenes.layout_file import find_layout

LAYOUT = find_layout("practice")
HERE = LAYOUT.boxes[5].pose.compose(Pose2(0.6, 0.0, np.pi))


class Publisher:
    """Keeps what is published; heard by as many as a test says."""

    made: ClassVar[Dict[str, Publisher]] = {}

    def __init__(self, topic: str, *_: Any, **__: Any) -> None:
        self.listeners, self.sent = 0, []
        self.made[topic] = self

    def get_num_connections(self) -> int:
        return self.listeners

    def publish(self, message: Any) -> None:
        self.sent.append(message)


class World:
    """A robot that stands."""

    ticks = 0
    truth = HERE


@pytest.fixture
def outbox(monkeypatch: pytest.MonkeyPatch) -> rgb.RgbOutbox:
    monkeypatch.setattr(rgb.rospy, "Publisher", Publisher)
    return rgb.RgbOutbox(World(), Camera(LAYOUT, 3), 30.0)


def run(outbox: rgb.RgbOutbox, ticks: int) -> List[bool]:
    drawn = []
    for _ in range(ticks):
        outbox._world.ticks += 1
        drawn.append(outbox.publish(rospy.Time.from_sec(0.01 * outbox._world.ticks)))
    return drawn


def test_nothing_is_drawn_while_nobody_listens(outbox: rgb.RgbOutbox) -> None:
    Publisher.made[names.RGB_INFO].listeners = 1
    assert not any(run(outbox, 20))
    assert len(Publisher.made[names.RGB_INFO].sent) == 6 and not Publisher.made[names.RGB_IMAGE].sent


def test_thirty_frames_a_second_are_those_of_the_camera(outbox: rgb.RgbOutbox) -> None:
    image = Publisher.made[names.RGB_IMAGE]
    run(outbox, 50)
    image.listeners = 1
    assert sum(run(outbox, 10)) == 3
    number = rgb.frame_number(round(image.sent[-1].header.stamp.to_sec() / 0.01), 30.0)
    drawn = Camera(LAYOUT, 3).frame(HERE, number)
    assert image.sent[-1].data == drawn.rgb().tobytes() and image.sent[-1].encoding == "rgb8"
    assert image.sent[-1].data != image.sent[-2].data
    assert np.count_nonzero(drawn.owners == 5) > 30000


def test_what_was_heard_before_changes_no_frame(outbox: rgb.RgbOutbox) -> None:
    image = Publisher.made[names.RGB_IMAGE]
    image.listeners = 1
    run(outbox, 10)
    late = rgb.RgbOutbox(World(), Camera(LAYOUT, 3), 30.0)
    run(late, 7)
    Publisher.made[names.RGB_IMAGE].listeners = 1
    run(late, 3)
    assert Publisher.made[names.RGB_IMAGE].sent[-1].data == image.sent[-1].data

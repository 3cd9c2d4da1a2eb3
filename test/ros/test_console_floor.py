"""What a page shows of the youBot on its floor, live: bodies, ways, what it does and refuses, a person's stop."""

from __future__ import annotations

import math

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from yarm.msg import SafetyStatus, YoubotStatus

from yarm.console.wire import decode
from yarm.resources import resource
from yarm.robots.youbot import NAME
from yarm.ros.common import names
from yarm.ros.common.bodies import registry_message, transform_message
from yarm.ros.console.floor_book import STATUS, WAY
from yarm.ros.console.system_book import SystemBook
from yarm.ros.manipulation.floor_outbox import moving_frames
from yarm.sim.scenes.youbot_floor import BASE_FRAME, CUP_FRAME, floor_bodies, load_floor_scene

SCENE = load_floor_scene(resource("scenes", "manipulation", "youbot_floor.yaml"))
BODIES = floor_bodies(SCENE)
BASE_AT, CUP_AT = (0.5, -0.2, 0.1, 0.0, 0.0, 0.0, 1.0), (0.9, -0.2, 0.2, 0.0, 0.0, 0.0, 1.0)


class Heard:
    """A book that has heard what the simulation says at its start."""

    def __init__(self):
        self.said = []
        self.book = SystemBook(lambda _: [], self.said.append)
        fixed = {frame: pose for body in BODIES for frame, pose in body.static_frames.items()}
        self.tell("/tf_static", transform_message(rospy.Time(), fixed))
        self.tell(names.OBJECT_REGISTRY, registry_message(rospy.Time(), BODIES))

    def tell(self, topic, message, at_s=1.0):
        self.book.routes()[topic].take(message)
        self.book.heard(topic, at_s, at_s)

    def state(self, at_s=1.0):
        return decode(self.book.state(at_s, at_s))


@pytest.fixture
def heard():
    found = Heard()
    found.tell("/tf", moving_frames(rospy.Time(), {BASE_FRAME: BASE_AT, CUP_FRAME: CUP_AT}))
    found.tell(
        STATUS, YoubotStatus(debris=["debris_1", "debris_2"], in_bin=[True, False], doing="debris_1 is in the bin")
    )
    return found


def test_bodies_are_where_their_frames_say(heard):
    scene, _ = decode(heard.book.parts()["scene"].message)
    header, arrays = heard.state()
    assert header["scene"] == scene["version"]
    assert {body["name"] for body in scene["bodies"]} == {body.name for body in BODIES}
    assert sum(len(body.solids) for body in BODIES) == len(scene["solids"])
    poses = dict(zip(scene["frames"], arrays["poses"]))
    np.testing.assert_allclose(poses[BASE_FRAME], BASE_AT, atol=1e-6)
    np.testing.assert_allclose(poses["bin"][:2], (SCENE.bin.place.x, SCENE.bin.place.y), atol=1e-6)


def test_it_says_what_it_does_and_what_it_refused(heard):
    header, _ = heard.state()
    facts = dict(header["room"]["facts"])
    assert header["room"]["title"] == "youBot: commanded"
    assert header["commander"] is None and header["tasks"] == []
    assert facts["in the bin"] == "1 of 2 pieces"
    assert facts["does"] == "debris_1 is in the bin"
    assert facts["motion"] == "stands"
    assert "refused" not in facts
    heard.tell(STATUS, YoubotStatus(clearing=True, refused="it clears the floor by itself", left=1.25))
    header, _ = heard.state()
    facts = dict(header["room"]["facts"])
    assert header["room"]["title"] == "youBot: clears its floor"
    assert facts["refused"] == "it clears the floor by itself"
    assert facts["motion"] == "1.2 s left"


def test_ways_behind_and_the_motion_under_way_are_drawn(heard):
    heard.state()
    moved = {BASE_FRAME: (0.6, *BASE_AT[1:]), CUP_FRAME: (1.0, *CUP_AT[1:])}
    heard.tell("/tf", moving_frames(rospy.Time(), moved))
    path = Path(poses=[PoseStamped(), PoseStamped()])
    path.poses[1].pose.position.x = 1.0
    heard.tell(WAY, path)

    def layers():
        return {(line["layer"], line["name"]): line["count"] for line in heard.state()[0]["lines"]}

    assert layers() == {("driven", NAME): 2, ("driven", "hand"): 2}, "its motion has ended"
    heard.tell(STATUS, YoubotStatus(left=1.0))
    assert layers() == {("driven", NAME): 2, ("driven", "hand"): 2, ("path", "hand"): 2}


def test_a_stop_is_shown_and_silence_is_named(heard):
    heard.tell(names.SAFETY_STATUS, SafetyStatus(latched=True, reason="stopped by somebody"))
    assert heard.state()[0]["stop"] == {"latched": True, "reason": "stopped by somebody"}
    assert heard.state()[0]["silent"] == []
    assert heard.state(9.0)[0]["silent"] == [f"nothing heard on {STATUS} for 8 s: what is shown is old"]


def test_numbers_that_are_none_are_not_drawn(heard):
    path = Path(poses=[PoseStamped(), PoseStamped()])
    path.poses[0].pose.position.x = math.nan
    heard.tell(WAY, path)
    heard.tell(STATUS, YoubotStatus(joints=[math.inf] * 5, left=math.nan, press=math.nan, real_time_factor=math.inf))
    header, _ = heard.state()
    assert header["real_time_factor"] is None
    assert "joints" not in dict(header["room"]["facts"])
    assert all(line["layer"] != "path" for line in header["lines"])

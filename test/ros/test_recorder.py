"""Camera sets recorded from the simulation, as they go over the wire: what golden recordings and a benchmark play."""

from __future__ import annotations

from tf2_msgs.msg import TFMessage
from yarm.msg import ObjectRegistry

from support import recorder


def parsed(kind, data):
    message = kind()
    message.deserialize(data)
    return message


def test_a_set_holds_clouds_frames_and_the_registry_of_its_moment():
    taken = next(recorder.camera_sets("2m1ma"))
    assert taken.still and len(taken.clouds) == len(taken.messages()) == 4
    frames = {transform.child_frame_id for transform in parsed(TFMessage, taken.frames).transforms}
    entries = {entry.name: entry for entry in parsed(ObjectRegistry, taken.registry).entries}
    assert {"ankurbot_1", "ankurbot_2", "hc10_barc"} <= set(entries)
    assert {"ankurbot_1/base_link", "ankurbot_1/ee"} <= frames
    assert set(entries["ankurbot_1"].shape_frames) <= frames
    assert not frames & {transform.child_frame_id for transform in parsed(TFMessage, taken.fixed_frames).transforms}

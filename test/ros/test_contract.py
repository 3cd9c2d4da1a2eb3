"""The built messages against the contract: no field is lost by accident."""

from __future__ import annotations

import hashlib
import importlib
from pathlib import Path

import genmsg
import genmsg.gentools
import genmsg.msg_loader
import pytest
import yaml
from yarm.msg import BumperEvent

from yarm.robots.turtlebot import Bumper

ROOT = Path(__file__).resolve().parents[2]
TABLE = yaml.safe_load((ROOT / "test" / "data" / "contract.yaml").read_text())


def fields_of(name):
    kind, cls = name.split("/")
    message = getattr(importlib.import_module(f"yarm.{kind}"), cls)
    return dict(zip(message.__slots__, message._slot_types))


@pytest.mark.parametrize("name", sorted(TABLE))
def test_every_field_of_the_contract_is_built(name):
    built = fields_of(name)
    lost = {field: kind for field, kind in TABLE[name].items() if built.get(field) != kind}
    assert lost == {}, f"{name}: fields lost or of another type (wanted): {lost}; built: {built}"


def test_every_definition_comments_every_field():
    bare = []
    for path in sorted([*ROOT.glob("msg/*.msg"), *ROOT.glob("srv/*.srv"), *ROOT.glob("action/*.action")]):
        for line in path.read_text().splitlines():
            text = line.strip()
            if text not in ("", "---", "Header header") and "#" not in text and "=" not in text:
                bare.append(f"{path.name}: {text}")
    assert bare == []


KOBUKI_BUMPER_EVENT = """
uint8 LEFT=0
uint8 CENTER=1
uint8 RIGHT=2
uint8 RELEASED=0
uint8 PRESSED=1
uint8 bumper
uint8 state
"""
"""kobuki_msgs 0.7.0, without its comments."""


def test_a_bumper_event_is_a_kobukis():
    public = genmsg.gentools.compute_md5_text(
        genmsg.MsgContext.create_default(), parsed("kobuki_msgs/BumperEvent", KOBUKI_BUMPER_EVENT)
    )
    assert hashlib.md5(public.encode()).hexdigest() == BumperEvent._md5sum
    assert [Bumper.LEFT, Bumper.CENTER, Bumper.RIGHT] == [BumperEvent.LEFT, BumperEvent.CENTER, BumperEvent.RIGHT]


def parsed(name, text):
    return genmsg.msg_loader.load_msg_from_string(genmsg.MsgContext.create_default(), text, name)


def test_a_lost_field_is_noticed():
    assert fields_of("msg/GridIndex") != {"x": "int32", "y": "int32"}

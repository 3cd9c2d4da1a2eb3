"""What the console makes of messages, without a master: bytes of /tf, statuses, plans, logs, addresses."""

from __future__ import annotations

import io
import math
import threading
from types import SimpleNamespace

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Log
from rospy.impl.tcpros import DEFAULT_BUFF_SIZE
from tf2_msgs.msg import TFMessage
from yarm.msg import (
    CommanderStatus,
    GridIndex,
    GridIndexVector,
    ObjectRegistry,
    PlanReport,
    RegisteredObject,
    SafetyStatus,
    TaskStatus,
)

from yarm.console.params import ConsoleParams
from yarm.console.wire import decode
from yarm.geometry import GridSpec
from yarm.ros.common import names
from yarm.ros.console.cell_book import SENDERS
from yarm.ros.console.cell_words import commander_words, safety_words, ways_ahead
from yarm.ros.console.events import MOST, EventLog
from yarm.ros.console.filmer import Filmer
from yarm.ros.console.node import address
from yarm.ros.console.routes import Feed, stamp_of
from yarm.ros.console.system_book import SystemBook
from yarm.ros.console.throttle import AGAIN_S, throttled
from yarm.ros.console.transforms import PoseBook, read_transforms
from yarm.ros.console.view import LiveView


def serialised(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def transform(parent, child, x):
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id = parent
    made.transform.translation.x, made.transform.rotation.w = x, 1.0
    return made


def test_the_bytes_of_tf_are_read_as_rospy_reads_them():
    data = serialised(TFMessage([transform("world", "/a", 1.5), transform("a", "b\u00e4r", -2.0)]))
    assert list(read_transforms(data)) == [
        ("world", "a", (1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)),
        ("a", "b\u00e4r", (-2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)),
    ]


@pytest.mark.parametrize("cut", [0, 3, 20, 60])
def test_bytes_that_end_too_early_are_refused(cut):
    data = serialised(TFMessage([transform("world", "a", 1.5)]))
    with pytest.raises(ValueError, match="cannot be read"):
        list(read_transforms(data[:cut]))


def test_a_commander_that_was_not_heard_has_no_buttons():
    assert commander_words(None) == {"commander": None, "buttons": [], "tasks": []}
    assert commander_words(CommanderStatus(state=99)) == {"commander": None, "buttons": [], "tasks": []}


def test_a_commanders_status_becomes_words_buttons_and_tasks():
    task = TaskStatus(robot="r", goal="d", kind="Debris", status="moving", distance_left_m=math.nan)
    status = CommanderStatus(state=5, state_name="BOUNDLESS", busy=True, tasks=[task], elapsed_s=2.0)
    words = commander_words(status)
    assert words["commander"]["state"] == "BOUNDLESS"
    assert [button["label"] for button in words["buttons"] if not button["refusal"]] == ["previous_state"]
    assert words["tasks"] == [
        {"robot": "r", "goal": "d", "kind": "Debris", "status": "moving", "reason": "", "left_m": None}
    ]


def test_a_safety_monitors_word_becomes_stop_and_rooms():
    said = SafetyStatus(
        robots=["a", "b"], clearance_m=[math.inf, 0.25], nearest=["", "table"], stopped=[False, True], latched=True
    )
    said.reason = "stopped by somebody"
    words = safety_words(said)
    assert words["stop"] == {"latched": True, "reason": "stopped by somebody"}
    assert words["robots"][0] == {"name": "a", "clearance_m": None, "nearest": "", "held": False}
    assert words["robots"][1]["clearance_m"] == 0.25
    assert safety_words(None) == {"stop": None, "robots": []}


def test_a_plan_becomes_ways_over_the_middles_of_its_columns():
    spec = GridSpec()
    path = GridIndexVector([GridIndex(0, 0, 0), GridIndex(10, 20, 0)])
    (way,) = ways_ahead(PlanReport(robots=["r"], paths=[path]), spec)
    wanted = np.asarray(spec.lower[:2]) + (np.array([[0.5, 0.5], [10.5, 20.5]])) * spec.resolution[:2]
    assert (way.layer, way.name) == ("path", "r")
    np.testing.assert_allclose(way.points[:, :2], wanted)


@pytest.fixture
def events():
    return EventLog()


def said(events):
    return decode(events.part().message)[0]["events"]


def test_events_are_warnings_and_the_commanders_words_and_repeat_as_a_count(events):
    before = events.part().version
    for level, node, text in (
        (Log.INFO, "/commander", "state 1"),
        (Log.INFO, "/database", "boring"),
        (Log.WARN, "/database", "no input"),
        (Log.WARN, "/database", "no input"),
        (Log.ERROR, "/simulation", "gone"),
    ):
        events.note(Log(level=level, name=node, msg=text))
    assert [(each["node"], each["level"], each["text"], each["times"]) for each in said(events)] == [
        ("commander", "info", "state 1", 1),
        ("database", "warning", "no input", 2),
        ("simulation", "error", "gone", 1),
    ]
    assert events.part().version > before


def test_events_do_not_grow_for_ever(events):
    for i in range(3 * MOST):
        events.note(Log(level=Log.WARN, name="/n", msg=f"{i}" * 1000))
    assert len(said(events)) == MOST
    assert len(events.part().message) < MOST * 600


@pytest.mark.parametrize(
    ("host", "token", "wanted"),
    [
        ("127.0.0.1", "T", "http://127.0.0.1:8/#token=T"),
        ("::1", "T", "http://[::1]:8/#token=T"),
        ("localhost", "", "http://localhost:8/"),
        ("10.0.0.7", "T", "http://10.0.0.7:8/?token=T"),
        ("0.0.0.0", "T", "http://THIS-MACHINE:8/?token=T"),
    ],
)
def test_the_address_brings_the_token_where_it_is_needed(host, token, wanted):
    assert address(host, 8, token) == wanted


@pytest.fixture
def heard(monkeypatch):
    """A view whose topics and clocks the test holds: callbacks by topic, and wall and simulated seconds."""
    topics, clock = {}, {"wall": 100.0, "simulated": 10.0}
    monkeypatch.setattr("rospy.Subscriber", lambda topic, _, callback, **__: topics.setdefault(topic, callback))
    monkeypatch.setattr("rospy.get_time", lambda: clock["simulated"])
    held = SimpleNamespace(monotonic=lambda: clock["wall"])
    monkeypatch.setattr("yarm.ros.console.view.time", held)
    monkeypatch.setattr("yarm.ros.console.routes.time", held)
    return LiveView(ConsoleParams()), topics, clock


def silent(view):
    return decode(view.state())[0]["silent"]


def test_who_was_never_heard_is_named(heard):
    view, _, _ = heard
    assert [line.partition(" yet")[0] for line in silent(view)] == [
        f"nothing heard from {sender}" for sender in SENDERS.values()
    ]


def test_who_falls_silent_is_named_by_the_time_of_a_slow_simulator_too(heard):
    view, topics, clock = heard
    topics[names.COMMANDER_STATUS](CommanderStatus(state=3, state_name="MENU"))
    topics[names.SAFETY_STATUS](SafetyStatus())
    about = [names.COMMANDER_NODE, names.SAFETY_NODE]

    def named():
        return [node for node in about if any(f"from {node} for" in line for line in silent(view))]

    assert named() == []
    for _ in range(4):
        clock["wall"], clock["simulated"] = clock["wall"] + 2.5, clock["simulated"] + 0.5
        assert named() == [], "a status a second is no silence when seconds are slow"
    clock["wall"], clock["simulated"] = clock["wall"] + 2.5, clock["simulated"] + 2.5
    assert named() == about
    topics[names.COMMANDER_STATUS](CommanderStatus(state=3, state_name="MENU"))
    assert named() == [names.SAFETY_NODE]


def test_a_clock_that_stands_is_told(heard):
    view, _, clock = heard
    assert not any("stands still" in line for line in silent(view))
    clock["wall"] += 7.0
    assert "simulated time stands still for 7 s: what is shown is old" in silent(view)


def test_stamps_are_read_from_messages_and_from_bytes():
    status = SafetyStatus()
    status.header.stamp = rospy.Time(12, 500_000_000)
    raw = rospy.AnyMsg()
    raw.deserialize(serialised(status))
    assert stamp_of(status, SafetyStatus) == stamp_of(raw, SafetyStatus) == pytest.approx(12.5)
    assert stamp_of(TFMessage(), TFMessage) is None
    assert stamp_of(SafetyStatus(), SafetyStatus) is None


def test_the_same_warning_is_not_said_again_and_again():
    said, clock = [], SimpleNamespace(s=0.0)
    warn = throttled(said.append, lambda: clock.s)
    for _ in range(3):
        warn("a")
        warn("b")
    assert said == ["a", "b"]
    clock.s += AGAIN_S
    warn("a")
    assert said == ["a", "b", "a"]


def test_poses_are_read_from_messages_and_from_bytes_alike():
    message = TFMessage([transform("world", "/a", 1.5), transform("map", "odom", 2.0), transform("odom", "base", 0.5)])
    raw = rospy.AnyMsg()
    raw.deserialize(serialised(message))
    for each in (message, raw):
        book = PoseBook(pytest.fail)
        book.routes()["/tf"].take(each)
        assert book.newest() == {"a": (1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)}
        assert book.matrix("map", "base")[0, 3] == 2.5
        assert book.matrix("base", "map") is None


def test_a_film_beside_an_experiment_listens_to_poses_as_the_experiment_does(monkeypatch):
    kinds, waiting = {}, set()

    def subscribe(topic, kind, _, queue_size, buff_size, **__):
        kinds[topic] = kind
        waiting.add((queue_size, buff_size))

    monkeypatch.setattr("rospy.Subscriber", subscribe)
    Filmer("a run", 5.0, lambda: 0.0).end()
    assert kinds["/tf"] is kinds["/tf_static"] is TFMessage
    assert kinds[names.PLANNING_METADATA] is rospy.AnyMsg
    assert waiting == {(None, DEFAULT_BUFF_SIZE)}, "the last word on how many messages wait counts for all"


def test_a_latched_message_that_comes_while_subscribing_is_followed(monkeypatch):
    robot = RegisteredObject(name="ankurbot_1", object="Mobile", type="dynamic", seed_frame="a")
    topics = set()

    def subscribe(topic, _, take, **__):
        topics.add(topic)
        if topic == names.OBJECT_REGISTRY:
            take(ObjectRegistry(entries=[robot]))

    monkeypatch.setattr("rospy.Subscriber", subscribe)
    monkeypatch.setattr("rospy.get_time", lambda: 1.0)
    made = threading.Thread(target=lambda: Feed(SystemBook(lambda _: [], pytest.fail)), daemon=True)
    made.start()
    made.join(20.0)
    assert not made.is_alive(), "it waits for itself"
    assert f"{names.move_robot('ankurbot_1')}/goal" in topics
